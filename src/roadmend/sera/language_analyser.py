"""From incidents to failure patterns with a language model, whose every claim is held against the incidents."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Annotated, Any

from pydantic import ConfigDict, Field, TypeAdapter

from roadmend.language.chat import ChatModel
from roadmend.language.question import ATTEMPTS, Question
from roadmend.sera.analyser import in_order, pattern_of
from roadmend.sera.descriptor import OutcomeName
from roadmend.sera.incident import Incident
from roadmend.sera.incident_words import note_of_incident, words_of_incident
from roadmend.sera.pattern import FailurePattern, Where, Who, Why

_AT_ONCE = 60  # incidents in one question
_PARTS = ("where", "who", "why")  # of a pattern's structure
_LONGEST = 300  # characters of a text out of a bag
_ROLE = "You are an experienced safety engineer who finds out what a driving policy gets wrong again and again."
_TASK = """\
The data: "incidents" are failures of episodes and interventions of the repair node that guards the policy, each with a \
number; "known" are patterns that earlier incidents have shown.
The task: group the incidents into failure patterns, such that the incidents of a pattern could be mended by training on \
the same kind of scenario. Every incident belongs to exactly one pattern.
For each pattern give
  name: a short one; that of a known pattern if the incidents belong to it
  words: one sentence on what goes wrong, where, with whom and why
  what: how its episodes ended, all in the same way; null for interventions
  where, who, why: what its incidents have in common and matters for the failure. A value must stand in every one of \
them; whatever they differ in, do not say or does not matter is null. Never guess.
  evidence: the numbers of its incidents
Write your reasoning into "analysis" first."""


@dataclass(frozen=True, slots=True)
class _Pattern:
    __pydantic_config__ = ConfigDict(extra="forbid")

    name: Annotated[str, Field(min_length=1, max_length=120)]
    words: Annotated[str, Field(min_length=1, max_length=500)]
    what: OutcomeName | None
    where: Where
    who: Who
    why: Why
    evidence: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class _AnalysisAnswer:
    __pydantic_config__ = ConfigDict(extra="forbid")

    analysis: str
    patterns: tuple[_Pattern, ...]


_QUESTION = Question("failure_patterns", _ROLE, _TASK, TypeAdapter(_AnalysisAnswer))


@dataclass
class _Group:
    """A pattern while it is being found."""

    said: _Pattern
    incidents: list[Incident]


class LanguageAnalyser:
    """Lets a language model group the incidents and say what matters about each group.

    What it says of a group is kept only where it holds for every incident of it; an answer that says anything else is
    asked for again. Many incidents are handed over in portions, with the patterns found so far.

    Args:
        model: that is asked.
        attempts: answers that a portion may take.
    """

    name = "language"

    def __init__(self, model: ChatModel, attempts: int = ATTEMPTS) -> None:
        self.model = model
        self.attempts = attempts

    def analyse(self, incidents: Sequence[Incident]) -> tuple[FailurePattern, ...]:
        """The patterns, those with most evidence first.

        Raises:
            LanguageError: the model gave no answer, or none that holds, as often as it was asked.
        """
        ordered = in_order(incidents)
        groups: dict[str, _Group] = {}
        for start in range(0, len(ordered), _AT_ONCE):
            groups = self._group(ordered[start : start + _AT_ONCE], groups)
        patterns = [_pattern(group) for group in groups.values()]
        return tuple(sorted(patterns, key=lambda pattern: (-len(pattern.evidence), pattern.name)))

    def _group(self, portion: Sequence[Incident], known: dict[str, _Group]) -> dict[str, _Group]:
        answer = _QUESTION.ask(
            self.model, _data(portion, known), lambda said: _join(said, portion, known)[1], self.attempts
        )
        groups, _ = _join(answer, portion, known)
        return groups


def _data(portion: Sequence[Incident], known: dict[str, _Group]) -> dict[str, Any]:
    return {
        "known": [{"name": group.said.name, "words": group.said.words} for group in known.values()],
        "incidents": [{"number": number, **_record(incident)} for number, incident in enumerate(portion, 1)],
    }


def _record(incident: Incident) -> dict[str, Any]:
    """What the model is told of an incident; paths of this machine are none of its business."""
    facts = pattern_of("", [incident])
    return {
        "summary": words_of_incident(incident),
        "note": note_of_incident(incident),
        "what": facts.what,
        **{part: asdict(getattr(facts, part)) for part in _PARTS},
        "ego": {"action": incident.ego.action, "speed": incident.ego.speed},
        "other": None
        if incident.other is None
        else {
            "encounter": incident.other.encounter,
            "speed": incident.other.speed,
            "braking": incident.other.braking,
        },
        "manner": incident.manner,
        "ego_at_fault": incident.at_fault,
        "text": incident.text[:_LONGEST],
    }


def _join(
    answer: _AnalysisAnswer, portion: Sequence[Incident], known: dict[str, _Group]
) -> tuple[dict[str, _Group], list[str]]:
    """The groups with the portion added, and what is wrong with the answer."""
    groups = {name: _Group(group.said, [*group.incidents]) for name, group in known.items()}
    left = set(range(1, len(portion) + 1))
    objections: list[str] = []
    for said in answer.patterns:
        if said.name in groups and said.name not in known:
            objections.append(f"there are two patterns {said.name!r}")
        group = groups.setdefault(said.name, _Group(said, []))
        for number in said.evidence:
            if number in left:
                left.discard(number)
                group.incidents.append(portion[number - 1])
            else:
                fault = "is evidence more than once" if 1 <= number <= len(portion) else "does not exist"
                objections.append(f"pattern {said.name!r}: incident {number} {fault}")
        objections += _unfounded(said, group.incidents) if said.evidence else [f"pattern {said.name!r} has no evidence"]
    if left:
        objections.append(f"of no pattern are the incidents {', '.join(map(str, sorted(left)))}")
    return groups, objections


def _unfounded(said: _Pattern, incidents: Sequence[Incident]) -> list[str]:
    """What is said of incidents and does not hold for all of them."""
    if not incidents:
        return []  # all that it named were refused
    facts = pattern_of(said.name, incidents)
    wrong = []
    if len({incident.kind for incident in incidents}) > 1:
        wrong.append("its incidents ended in different ways")
    elif said.what != facts.what:
        wrong.append(f"what is {said.what!r}, and its incidents say {facts.what!r}")
    for part in _PARTS:
        claimed, held = getattr(said, part), getattr(facts, part)
        wrong += [
            f"{part}.{field.name} is {getattr(claimed, field.name)!r}, which does not stand in every one of its incidents"
            for field in fields(claimed)
            if getattr(claimed, field.name) not in {None, getattr(held, field.name)}
        ]
    return [f"pattern {said.name!r}: {each}" for each in wrong]


def _pattern(group: _Group) -> FailurePattern:
    """The facts of a group, of its structure those that were said to matter."""
    facts = pattern_of(group.said.name, group.incidents)
    return replace(
        facts,
        words=" ".join(group.said.words.split()),
        **{part: _said(getattr(group.said, part), getattr(facts, part)) for part in _PARTS},
    )


def _said(claimed: Any, held: Any) -> Any:
    return replace(held, **{field.name: None for field in fields(held) if getattr(claimed, field.name) is None})
