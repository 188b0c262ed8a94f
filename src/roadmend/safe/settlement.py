"""What is kept of an answer that has been checked, with what each field rests on and what speaks against it."""

from collections.abc import Mapping, Sequence
from typing import Any

from roadmend.core.errors import InputError
from roadmend.safe.answer_check import ANSWER, FieldCheck
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.extraction import Extraction, FieldEvidence
from roadmend.safe.reading_alignment import COLLISIONS, VEHICLES, agree, flat

_WHOLE = (VEHICLES, COLLISIONS)


def settle(
    scenario: CrashScenario, checks: Sequence[FieldCheck], reading: Extraction | None
) -> tuple[CrashScenario, dict[str, FieldEvidence]]:
    """Keep of every field the value with the best odds, and say so.

    Args:
        scenario: the answer.
        checks: of its fields.
        reading: what the embedded reader made of the report.
    """
    read = reading.scenario if reading is not None else None
    wanted = {check.field: check.kept for check in checks if not agree(check.field, check.kept, check.answered)}
    settled = _with(scenario, wanted, read)
    if settled is None:  # together they make no scenario, such as positions of another kind of road
        settled = scenario
        for field, value in wanted.items():
            settled = _with(settled, {field: value}, read) or settled
    return settled, _evidence(settled, checks)


def _with(scenario: CrashScenario, wanted: Mapping[str, Any], read: CrashScenario | None) -> CrashScenario | None:
    """A scenario with other values; None if the language does not have such a one."""
    data = dump_data(scenario)
    theirs = dump_data(read) if read is not None else {}
    for field in sorted(wanted, key=lambda name: name not in _WHOLE):  # others stand within these
        if field in _WHOLE:
            data[field] = theirs.get(field, [])
            if field == VEHICLES:
                data[COLLISIONS] = theirs.get(COLLISIONS, [])
        else:
            _put(data, field, wanted[field])
    try:
        return parse_data(data, ANSWER)
    except InputError:
        return None


def _put(data: Any, field: str, value: Any) -> None:
    *path, last = field.replace("[", ".[").split(".")
    for part in path:
        place = int(part[1:-1]) if part.startswith("[") else part
        if isinstance(data, list) and not (isinstance(place, int) and place < len(data)):
            return  # of a vehicle or a contact that is not there
        data = data[place]
    data[last] = value


def _evidence(settled: CrashScenario, checks: Sequence[FieldCheck]) -> dict[str, FieldEvidence]:
    values = flat(settled)
    found = {}
    for check in checks:
        value = values.get(check.field)
        is_counted = check.field in _WHOLE
        if (is_counted and not check.against) or (not is_counted and check.field not in values):
            continue
        found[check.field] = _of_field(check, value)
    return found


def _of_field(check: FieldCheck, value: Any) -> FieldEvidence:
    confidence = round(check.belief(value), 2)
    supporters = [each for each in check.said[1:] if each.value is not None and agree(check.field, each.value, value)]
    sentence = next((each.sentence for each in supporters if each.sentence is not None), None)
    if check.against:
        is_answer = agree(check.field, value, check.answered)
        whose = ANSWER if is_answer else " and ".join(each.source for each in supporters)
        against = ", ".join(dict.fromkeys(each.source for each in check.against))
        other = f"against {against}" if is_answer else f"not {ANSWER}, {_shown(check.answered)}"
        return FieldEvidence(
            value, sentence, confidence, f"disputed: kept what {whose} says, {other}", disputed=check.said
        )
    if supporters:
        names = " and ".join(dict.fromkeys(each.source for each in supporters))
        return FieldEvidence(value, sentence, confidence, f"{ANSWER}, as {names} has it")
    alone = f"{ANSWER} alone, see the exchanges"
    return FieldEvidence(value, None, confidence, alone if value is not None else f"{ANSWER}: it is not said")


def _shown(value: Any) -> str:
    return "null" if value is None else str(value)
