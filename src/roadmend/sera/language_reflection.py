"""The second look with a language model: swaps among the candidates that it was shown, each with its reason."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Field, TypeAdapter

from roadmend.language.chat import ChatModel
from roadmend.language.question import ATTEMPTS, Question
from roadmend.sera.reflection import Pick, Pool, Swap, Worth

_ALTERNATIVES = 15  # candidates beside the selection that are shown, for each pattern
_LONGEST = 500  # characters of a scenario in words
_ROLE = "You are an experienced engineer who puts together small training sets for driving policies."
_TASK = """\
The data: "patterns" are what a policy fails at; "selected" are scenarios chosen for one pattern each, by likeness; \
"others" are scenarios that may take their place, each for the patterns that it was found for.
The task: look at the selection as a whole and say which scenarios to swap, so that the policy learns most from it:
  coverage: together the scenarios of a pattern show all that the pattern is made of
  diversity and redundancy: no two scenarios teach the same
  difficulty: none is too easy or too hard to learn from; where runs of policies have failed, there is more to learn
Swap only what makes the set better; no swap at all is an answer, too.
For each swap give the number of the selected scenario that goes ("out"), the number of the other that comes ("into") \
and the reason in one sentence. A scenario goes or comes at most once.
Write your reasoning into "analysis" first."""


@dataclass(frozen=True, slots=True)
class _Swap:
    __pydantic_config__ = ConfigDict(extra="forbid")

    out: int
    into: int
    reason: Annotated[str, Field(min_length=1, max_length=500)]


@dataclass(frozen=True, slots=True)
class _ReflectionAnswer:
    __pydantic_config__ = ConfigDict(extra="forbid")

    analysis: str
    swaps: tuple[_Swap, ...]


_QUESTION = Question("reflection", _ROLE, _TASK, TypeAdapter(_ReflectionAnswer))


class LanguageReflector:
    """Lets a language model name the swaps; what it names must have been shown to it.

    Args:
        model: that is asked.
        attempts: answers that it may take.
    """

    def __init__(self, model: ChatModel, attempts: int = ATTEMPTS) -> None:
        self.model = model
        self.attempts = attempts

    def reflect(self, pool: Pool, initial: Sequence[Pick]) -> tuple[list[Pick], list[Swap]]:
        """The selection after the swaps, and the swaps.

        Raises:
            LanguageError: the model gave no answer, or none that can be carried out, as often as it was asked.
        """
        if not initial:
            return [], []
        others = _others(pool, initial)
        answer = _QUESTION.ask(
            self.model,
            _data(pool, initial, others),
            lambda said: _objections(said.swaps, initial, others),
            self.attempts,
        )
        return _carried_out(pool, initial, answer.swaps)


def _others(pool: Pool, initial: Sequence[Pick]) -> dict[int, list[int]]:
    """Numbers of candidates beside the selection, each with the patterns that it is among the best for."""
    taken = {pick.number for pick in initial}
    found: dict[int, list[int]] = {}
    for pattern, scores in enumerate(pool.scores):
        order = [pool.candidates[place].number for place in np.argsort(-scores, kind="stable")]
        for number in [number for number in order if number not in taken][:_ALTERNATIVES]:
            found.setdefault(number, []).append(pattern)
    return found


def _data(pool: Pool, initial: Sequence[Pick], others: dict[int, list[int]]) -> dict[str, Any]:
    def shown(number: int, patterns: Sequence[int]) -> dict[str, object]:
        candidate = pool.candidates[pool.places[number]]
        return {
            "number": number,
            "patterns": [pattern + 1 for pattern in patterns],
            "scenario": candidate.words[:_LONGEST],
            "likeness": [round(float(pool.scores[pattern, pool.places[number]]), 3) for pattern in patterns],
            "difficulty": candidate.difficulty or None,
            "runs": candidate.runs,
            "failures": candidate.failures,
        }

    return {
        "patterns": [{"number": number, "words": words} for number, words in enumerate(pool.patterns, 1)],
        "selected": [shown(pick.number, [pick.pattern]) for pick in initial],
        "others": [shown(number, patterns) for number, patterns in others.items()],
    }


def _objections(named: Sequence[_Swap], initial: Sequence[Pick], others: dict[int, list[int]]) -> list[str]:
    leaving = {pick.number: pick.pattern for pick in initial}
    coming = dict(others)
    wrong = []
    for swap in named:
        pattern, patterns = leaving.pop(swap.out, None), coming.pop(swap.into, None)
        if pattern is None:
            wrong.append(f"scenario {swap.out} is not selected, or goes twice")
        if patterns is None:
            wrong.append(f"scenario {swap.into} is not among the others, or comes twice")
        if pattern is not None and patterns is not None and pattern not in patterns:
            wrong.append(f"scenario {swap.into} was not found for pattern {pattern + 1}, that of scenario {swap.out}")
    return wrong


def _carried_out(pool: Pool, initial: Sequence[Pick], named: Sequence[_Swap]) -> tuple[list[Pick], list[Swap]]:
    picks, swaps, worth = [*initial], list[Swap](), Worth(pool)
    for swap in named:
        row = next(row for row, pick in enumerate(picks) if pick.number == swap.out)
        pattern = picks[row].pattern
        gain = float(worth.gains(picks)[row, pool.places[swap.into]])
        swaps.append(Swap(swap.out, swap.into, pattern, gain, " ".join(swap.reason.split())))
        picks[row] = pool.pick(swap.into, pattern)
    return picks, swaps
