"""A model's answers held against what is known without it: a fluent liar must not pass.

Witnesses are the embedded reader with what it read of text and sketch, the model's own meta message, the words that
stand in the text, and the geometry of the scene. They are taken as independent: a value is as probable as the product of
what each gives it, and each gives what its confidence leaves to the other values a field can have in equal parts. The
meta message, being of the same model, can speak against an answer but not for it. Words of the report never become a part
of an objection, which a model reads as an instruction.
"""

import functools
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from roadmend.safe.answer_schema import answer_schema
from roadmend.safe.dsl import CrashScenario, Position
from roadmend.safe.encoder import MetaMessage
from roadmend.safe.extraction import Extraction, Witness
from roadmend.safe.made_up import why_made_up
from roadmend.safe.reading_alignment import COLLISIONS, VEHICLES, AlignedField, agree, aligned_fields, flat
from roadmend.safe.report import CrashReport
from roadmend.safe.scene_contradictions import contradictions

ANSWER, SILENCE, ALONE, READER, SKETCH, META, TEXT, GEOMETRY = (
    "the model's answer",
    "the model's null",
    "the model's answer, of which a reader of the same text finds nothing",
    "the embedded reader",
    "the embedded reader of the sketch",
    "the meta message",
    "the words of the text",
    "the geometry of the scene",
)
TRUST: Mapping[str, float] = {  # where a source gives no confidence of its own
    ANSWER: 0.8,  # the paper's share of reports whose actors GPT-4o gets right
    SILENCE: 0.6,
    ALONE: 0.6,
    READER: 0.75,
    META: 0.6,  # the same model
    TEXT: 0.75,
    GEOMETRY: 0.7,
}
ASKED_BELOW = 0.75  # belief in a field under which the model is asked again
HEARD_FROM = 2.0  # times that a witness finds its value more probable than any other one, to be heard
_CHOICES = {"num_lanes": 6, "speed_limit_mph": 10, "striking": 2, "struck": 2, VEHICLES: 4, COLLISIONS: 4}  # of numbers
_OTHER = object()  # a value that nobody names
_RAMPS = {Position.MAIN_ROAD, Position.ON_RAMP}


@dataclass(frozen=True, slots=True)
class FieldCheck:
    """A field of an answer and what all witnesses say of it.

    Attributes:
        field: as the JSON form calls it; "vehicles" and "collisions" stand for how many there are.
        said: by whom; the answer first.
    """

    field: str
    said: tuple[Witness, ...]

    @property
    def answered(self) -> Any:
        """The answer's value."""
        return self.said[0].value

    @property
    def against(self) -> list[Witness]:
        """Those who speak against the answer's value and have to be heard."""
        return [
            each
            for each in self.said[1:]
            if not self._speaks_for(each, self.answered)
            and (each.value is None or each.confidence >= HEARD_FROM * self._of_others(each.confidence))
        ]

    @property
    def kept(self) -> Any:
        """The value with the best odds; the answer's where no other has better ones."""
        values = [self.answered, *(each.value for each in self.said[1:] if each.value is not None)]
        return max(values, key=self.belief)  # the first of equals

    def belief(self, value: Any) -> float:
        """From 0 to 1, in a value."""
        named = {value: None, self.answered: None} | {each.value: None for each in self.said if each.value is not None}
        values: list[Any] = []
        for each in named:  # those that say the same count once
            if not any(agree(self.field, each, known) for known in values):
                values.append(each)
        weights = [self._weight(each) for each in values]
        rest = max(choices(self.field) - len(values), 0) * self._weight(_OTHER)
        return self._weight(value) / (sum(weights) + rest)

    def _weight(self, value: Any) -> float:
        """How probable all make a value together, but for a factor."""
        product = 1.0
        for each in self.said:
            sure = min(max(each.confidence, 0.02), 0.98)  # nobody is beyond all doubt
            is_for = self._speaks_for(each, value)
            if each.value is None and each.source != ANSWER:
                product *= sure if is_for else 1.0 - sure
            else:
                product *= sure if is_for else self._of_others(sure)
        return product

    def _of_others(self, confidence: float) -> float:
        """What a confidence in one value leaves to each other one."""
        return (1.0 - confidence) / max(choices(self.field) - 1, 1)

    def objection(self) -> str | None:
        """What to tell the model; None where the answer is believed."""
        if not self.against or self.belief(self.answered) >= ASKED_BELOW:
            return None
        told = [each.ground if each.value is None else f"{each.source} says {each.value}" for each in self.against]
        answered = "null" if self.answered is None else self.answered
        return f"{self.field}: you answered {answered}; {'; '.join(told)}"

    def _speaks_for(self, each: Witness, value: Any) -> bool:
        if each.value is None and each.source != ANSWER:  # all that it says is that the answer is wrong
            return not agree(self.field, value, self.answered)
        return agree(self.field, each.value, value)


@functools.cache
def choices(field: str) -> int:
    """How many values a field can have, in effect."""
    name = field.rpartition(".")[2]
    return _CHOICES.get(name) or _words(answer_schema()).get(name, 2)


def _words(schema: Mapping[str, Any]) -> dict[str, int]:
    """By field, how many words a schema has for it."""
    found = {}
    for name, content in schema.get("properties", {}).items():
        if "enum" in content:
            found[name] = sum(word is not None for word in content["enum"])
        found |= _words(content.get("items", content))
    return found


def unchecked(scenario: CrashScenario) -> Iterator[FieldCheck]:
    """The fields of a scenario, with nobody but the answer that speaks of them."""
    for field, value in flat(scenario).items():
        yield FieldCheck(field, (_answer(field, value),))


def _answer(field: str, value: Any, *, is_alone: bool = False) -> Witness:
    """The model's own word; not to have found a thing is easier than to have found what is not there."""
    is_silent = value is None or (field == COLLISIONS and value == 0)
    return Witness(ANSWER, value, TRUST[SILENCE if is_silent else ALONE if is_alone else ANSWER])


class AnswerCheck:
    """What speaks for and against the answers about one report.

    Args:
        report: that they are about.
        reading: the embedded reader's; None where it could not read it.
        unread: why it could not.
    """

    def __init__(self, report: CrashReport, reading: Extraction | None, unread: str = "") -> None:
        self.report = report
        self.reading = reading
        self.unread = unread

    def of_meta(self, meta: MetaMessage) -> list[FieldCheck]:
        """The fields of a meta message that are disputed."""
        if self.reading is None:
            return []
        answered = dict(_of_meta(meta))
        read = {name: AlignedField(value, name) for name, value in flat(self.reading.scenario).items()}
        checks = []
        for field, value in answered.items():
            if field != VEHICLES and field.startswith(VEHICLES) and answered[VEHICLES] != read[VEHICLES].value:
                continue
            said = (_answer(field, value), *self._reader(field, value, read))
            checks.append(FieldCheck(field, said))
        return [check for check in checks if check.against]

    def of_scenario(self, scenario: CrashScenario, meta: MetaMessage | None) -> list[FieldCheck]:
        """Every field of a scenario with what is said of it."""
        answered = flat(scenario)
        told = dict(_of_meta(meta)) if meta is not None else {}
        read = self._read(scenario)
        against: dict[str, list[Witness]] = {}
        for each in contradictions(scenario):
            for field in each.fields:
                against.setdefault(field, []).append(Witness(GEOMETRY, None, TRUST[GEOMETRY], each.reason))
        checks = []
        for field in {**answered, **read}:
            value = answered.get(field)
            heard = [*self._reader(field, value, read)]
            said = [_answer(field, value, is_alone=self.reading is not None and not heard), *heard]
            said += self._meta(field, value, told, answered)
            said += against.get(field, [])
            said += self._text(field, value)
            checks.append(FieldCheck(field, tuple(said)))
        return checks

    def _read(self, scenario: CrashScenario) -> dict[str, AlignedField]:
        if self.reading is None:
            return {}
        return aligned_fields(scenario, self.reading.scenario, self.report.summary)

    def _reader(self, field: str, answered: Any, read: Mapping[str, AlignedField]) -> Iterator[Witness]:
        if self.reading is None or field not in read:
            return
        value = read[field].value
        if value is None or (field == COLLISIONS and value == 0):
            return  # what it did not find it says nothing of
        if field.endswith("manoeuvre") and answered is None:
            return  # the answer keeps to the paper's words
        evidence = self.reading.evidence.get(read[field].field)
        if evidence is None or evidence.confidence is None:
            yield Witness(READER, value, TRUST[READER])
        else:
            source = SKETCH if evidence.box is not None else READER
            yield Witness(source, value, evidence.confidence, evidence.reason, evidence.sentence)

    def _meta(
        self, field: str, answered: Any, told: Mapping[str, Any], all_answered: Mapping[str, Any]
    ) -> Iterator[Witness]:
        value = told.get(field)
        is_elsewhere = field.endswith("initial_position") and (
            told.get(VEHICLES) != all_answered[VEHICLES] or (value in _RAMPS) != (answered in _RAMPS)
        )
        if value is not None and not is_elsewhere and not agree(field, value, answered):
            yield Witness(META, value, TRUST[META], "answered before")

    def _text(self, field: str, value: Any) -> Iterator[Witness]:
        """The text itself, where there is no sketch that could show what it does not say."""
        lack = why_made_up(field, value, self.report.summary) if self.report.sketch is None else None
        if lack is not None:
            yield Witness(TEXT, None, TRUST[TEXT], lack)


def _of_meta(meta: MetaMessage) -> Iterator[tuple[str, Any]]:
    yield "road_type", meta.road_type.value
    yield VEHICLES, len(meta.directions)
    for index, direction in enumerate(meta.directions):
        if direction is not None:
            yield f"{VEHICLES}[{index}].initial_position", direction.value
