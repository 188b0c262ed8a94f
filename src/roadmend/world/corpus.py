"""A corpus: scenarios that a policy is repaired, trained and measured on, each with what the bare policy makes of it."""

import hashlib
import json
from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Self

from roadmend import __version__
from roadmend.core.bounded_file import read_text
from roadmend.core.bounds import TEXT
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.core.outcome import Blame, EventKind
from roadmend.core.resources import config_folder
from roadmend.core.whole_file import write_text
from roadmend.world.families import FAMILY_REGISTRY, Family
from roadmend.world.point_text import dump_point, parse_point
from roadmend.world.scenario import Scenario
from roadmend.world.space import Parameters

FORMAT = "roadmend-corpus/3"
SPLITS = ("training", "validation", "test")
TOUCH = 2.0  # [m/s] of the ego, below which a collision is called a touch
METHOD = "none"  # the repair method under which outcomes and digests were taken
_COLLISION = EventKind.COLLISION.name
_OF_COLLISION = ("blame", "partner", "impact_speed", "persistence")
_AGAIN = "build it again with 'roadmend corpus build'"


@dataclass(frozen=True)
class Case:
    """One scenario and what it came to without repair."""

    name: str
    family: str
    split: str
    seed: int  # of the traffic
    parameters: Parameters  # of the family's space, those that the scenario depends on
    outcome: str  # GOAL or COLLISION
    digest: str  # of the trajectory
    technique: str  # that found it
    search_seed: int
    index: int  # of the evaluation in that search
    text: str  # of the final event
    min_distance: float | None  # [m] between the outlines, over time; none where the ego met nobody
    duration: float  # [s] simulation time
    blame: str = Blame.UNKNOWN.name  # of the collision
    partner: str = ""  # whom the ego hit first, by kind; empty without a collision
    impact_speed: float | None = None  # [m/s] of the ego at the collision, to a tenth; none without one
    persistence: float | None = None  # of the collision, see ``measures.need``; none where it was not looked at

    @property
    def is_touch(self) -> bool:
        """Whether the ego all but stood when it collided."""
        return self.impact_speed is not None and self.impact_speed < TOUCH

    @property
    def is_violation(self) -> bool:
        """Whether the bare policy collides by its own fault; other collisions are in no corpus."""
        return self.outcome == _COLLISION

    def scenario(self) -> Scenario:
        """The scenario, ready to be run.

        Raises:
            InputError: the family has come to depend on a parameter that the case does not have.
        """
        try:
            return _family(self.family).build(self.parameters, self.name, self.seed)
        except KeyError as error:
            raise InputError(self.name, f"has no parameter {error}", _AGAIN) from None

    def dump(self, without: Collection[str] = ()) -> str:
        """As a line of JSON, perhaps without some fields."""
        left_out = {*without, *(() if self.is_violation else _OF_COLLISION)}
        content = {name: value for name, value in asdict(self).items() if name not in left_out}
        content["parameters"] = dump_point(_family(self.family).space, self.parameters)
        return json.dumps(content, separators=(",", ":"), allow_nan=False) + "\n"

    @classmethod
    def parse(cls, line: str) -> Self:
        """From a line of JSON.

        Raises:
            ValueError: the line is no case.
        """
        try:
            content = parse_json(line, "case", is_line=True)
            if content["split"] not in SPLITS:
                raise ValueError(f"there is no split {content['split']!r}")
            content["parameters"] = parse_point(_family(content["family"]).space, content["parameters"])
            return cls(**content)
        except (AttributeError, KeyError, TypeError) as error:
            raise ValueError(str(error)) from None
        except InputError as error:
            raise ValueError(error.what) from None


def told_of(result: EpisodeResult) -> dict[str, Any]:
    """The fields of a case that say what it came to."""
    final = result.final
    return {
        "outcome": result.outcome.name,
        "digest": result.digest,
        "text": result.text,
        "min_distance": result.min_distance,
        "duration": result.duration,
        "blame": final.blame.name,
        "partner": final.object_kinds[0].name.lower() if final.object_kinds else "",
        "impact_speed": None if final.impact_speed is None else round(final.impact_speed, 1),
    }


@dataclass(frozen=True)
class Corpus:
    """Cases of one policy. Holds no time and no place: gathering again gives the same content and digest."""

    policy: str
    cases: tuple[Case, ...]  # sorted by family, split and origin
    model: str | None = None  # digest of the policy's model; none where it has none
    command: str = ""  # that made it
    plan: Mapping[str, Any] = field(default_factory=dict)  # what was asked for, as plain values
    dropped: int = 0  # candidates that did not come to the same when they were run again
    fleeting: int = 0  # violations that were not taken, as too few of their futures violate again
    version: str = __version__  # of roadmend

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the corpus, hexadecimal; deaf to what is only told of a collision.

        So the corpora that ship go by the digest under which models were trained before they told it.
        """
        return hashlib.sha256(dump_corpus(self, _OF_COLLISION).encode()).hexdigest()

    def select(
        self, family: str | None = None, split: str | None = None, *, violation: bool | None = None
    ) -> list[Case]:
        """Cases of a family, a split and a kind, in order; None stands for all.

        Raises:
            InputError: there is no such family or split.
        """
        if family is not None:
            _family(family)
        if split is not None and split not in SPLITS:
            raise InputError("split", f"there is no {split!r}", f"choose one of {', '.join(SPLITS)}")
        return [
            case
            for case in self.cases
            if family in (None, case.family) and split in (None, case.split) and violation in (None, case.is_violation)
        ]


def _family(name: str) -> Family:
    """Ours, or an installed package's: a corpus makes nobody run code that they did not install."""
    return FAMILY_REGISTRY.find_installed(name).entry


def sorted_cases(cases: Iterable[Case]) -> tuple[Case, ...]:
    """In the order of a corpus: by family, split, and where they were found."""
    return tuple(
        sorted(cases, key=lambda case: (case.family, SPLITS.index(case.split), case.search_seed, case.index, case.name))
    )


def dump_corpus(corpus: Corpus, without: Collection[str] = ()) -> str:
    """The corpus as JSON lines: a header, then one case a line, perhaps without some fields."""
    families = {case.family for case in corpus.cases}
    counts = Counter(f"{case.family} {case.split} {case.outcome}" for case in corpus.cases)
    header = {
        "format": FORMAT,
        "policy": corpus.policy,
        "model": corpus.model,
        "method": METHOD,
        "roadmend": corpus.version,
        "command": corpus.command,
        "plan": corpus.plan,
        # Of the families that occur: another one that is registered does not make this another corpus.
        "spaces": {name: _space_digest(name) for name in FAMILY_REGISTRY.names if name in families},
        "dropped": corpus.dropped,
        "fleeting": corpus.fleeting,
        "cases": len(corpus.cases),
        "counts": dict(sorted(counts.items())),
    }
    return json.dumps(header, separators=(",", ":")) + "\n" + "".join(case.dump(without) for case in corpus.cases)


def save_corpus(corpus: Corpus, path: Path) -> None:
    """Write a corpus, complete or not at all.

    Raises:
        InputError: the place cannot be written.
    """
    write_text(path, dump_corpus(corpus))


def load_corpus(path: Path) -> Corpus:
    """Read a corpus.

    Raises:
        InputError: the file is missing, is no corpus, is cut short or damaged, or was made for other parameter spaces.
    """
    lines = read_text(path, TEXT, "give a corpus; 'roadmend corpus build' makes one").splitlines()
    header = _parse_header(path, lines[0] if lines else "")
    if len(lines) - 1 != header["cases"]:
        raise InputError(str(path), f"holds {len(lines) - 1} of {header['cases']} cases", _AGAIN)
    cases: list[Case] = []
    for number, line in enumerate(lines[1:], 2):
        try:
            cases.append(Case.parse(line))
        except ValueError as error:
            raise InputError(f"{path} line {number}", f"is no case ({error})", _AGAIN) from None
        if cases[-1].family not in header["spaces"]:
            raise _other_space(path, cases[-1].family)
    return Corpus(
        header["policy"],
        tuple(cases),
        header["model"],
        header["command"],
        header["plan"],
        header["dropped"],
        header["fleeting"],
        header["roadmend"],
    )


_HEADER = ("policy", "model", "roadmend", "command", "plan", "spaces", "dropped", "fleeting", "cases")


def has_corpus(policy: str) -> bool:
    """Whether a corpus of the policy ships."""
    return _shipped(policy).is_file()


def corpus_of(policy: str, file: Path | None = None) -> Corpus:
    """A policy's corpus: that of a file, or the one that ships.

    Raises:
        InputError: there is none, it is damaged, or it is of another policy.
    """
    path = file or _shipped(policy)
    corpus = load_corpus(path)
    if corpus.policy != policy:
        raise InputError(str(path), f"is a corpus of the policy '{corpus.policy}'", f"give one of '{policy}'")
    return corpus


def _shipped(policy: str) -> Path:
    return config_folder() / "corpora" / f"{policy}.jsonl"


def _parse_header(path: Path, line: str) -> dict[str, Any]:
    try:
        header = parse_json(line, str(path))
        is_corpus = str(header.get("format")).startswith("roadmend-corpus/")
    except (InputError, AttributeError):
        is_corpus = False
    if not is_corpus:
        raise InputError(str(path), "is no corpus", "give a file that 'roadmend corpus build' made")
    if header["format"] != FORMAT:
        raise InputError(str(path), f"has the format {header['format']!r}, not {FORMAT!r}", _AGAIN)
    missing = [name for name in _HEADER if name not in header]
    if missing:
        raise InputError(f"{path} line 1", f"lacks {missing[0]}", _AGAIN)
    if not isinstance(header["spaces"], Mapping):
        raise InputError(f"{path} line 1", "names no parameter spaces", _AGAIN)
    for name, digest in header["spaces"].items():
        if name not in FAMILY_REGISTRY.names or digest != _space_digest(name):
            raise _other_space(path, name)
    return dict(header)


def _other_space(path: Path, family: str) -> InputError:
    return InputError(str(path), f"was made for another parameter space of {family}", _AGAIN)


def _space_digest(family: str) -> str:
    """Of the names, kinds, ranges and options of a space, shortened: the points' text leans on them."""
    return hashlib.sha256(repr([*_family(family).space.items()]).encode()).hexdigest()[:16]
