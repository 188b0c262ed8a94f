"""What is kept of an answer that has been checked, with what each field rests on and what speaks against it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from roadmend.core.errors import InputError
from roadmend.safe.answer_check import ANSWER, READER, TRUST, FieldCheck
from roadmend.safe.dsl import CrashScenario, DescribedRoadNetwork
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.extraction import Extraction, FieldEvidence
from roadmend.safe.reading_alignment import COLLISIONS, IMPACTS, VEHICLES, agree, flat, renumbered_collisions

_WHOLE = (VEHICLES, COLLISIONS)


def settle(
    scenario: CrashScenario, checks: Sequence[FieldCheck], reading: Extraction | None, summary: str
) -> tuple[CrashScenario, dict[str, FieldEvidence]]:
    """Keep of every field the likeliest value, and say so.

    Where the embedded reader is to be believed in how many vehicles there were, all of its vehicles, their contacts and
    their impacts are kept, for its numbers are not those of the answer.

    Args:
        scenario: the answer.
        checks: of its fields.
        reading: what the embedded reader made of the report.
        summary: of the report.
    """
    wanted = {check.field: check.kept for check in checks if not agree(check.field, check.kept, check.answered)}
    if reading is not None and VEHICLES in wanted:
        read = reading.scenario
        theirs = {VEHICLES: read.vehicles, COLLISIONS: read.collisions, IMPACTS: read.impacts}
        scenario = _replaced(scenario, road=read.road, **theirs)
        wanted = {field: value for field, value in wanted.items() if not field.startswith((*theirs,))}
    elif reading is not None and COLLISIONS in wanted:
        contacts = renumbered_collisions(scenario, reading.scenario, summary)
        scenario = _replaced(scenario, collisions=contacts)
        wanted = {field: value for field, value in wanted.items() if not field.startswith(COLLISIONS)}
    settled = _with(scenario, wanted)
    if settled is None:  # together they make no scenario, such as positions of another kind of road
        settled = scenario
        for field, value in wanted.items():
            settled = _with(settled, {field: value}) or settled
    return settled, _evidence(settled, checks, reading)


def _replaced(scenario: CrashScenario, road: DescribedRoadNetwork | None = None, **parts: Any) -> CrashScenario:
    """A scenario with other parts, and another road if they are not on this one; as it was if that is none."""
    choices: list[dict[str, Any]] = [parts, parts if road is None else {**parts, "road": road}]
    for choice in choices:
        try:
            return replace(scenario, **choice)
        except ValueError:
            continue
    return scenario


def _with(scenario: CrashScenario, wanted: Mapping[str, Any]) -> CrashScenario | None:
    """A scenario with other values; None if the language does not have such a one."""
    data = dump_data(scenario)
    for field, value in wanted.items():
        _put(data, field, value)
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


def _evidence(
    settled: CrashScenario, checks: Sequence[FieldCheck], reading: Extraction | None
) -> dict[str, FieldEvidence]:
    known = {check.field: check for check in checks}
    read = reading.evidence if reading is not None else {}
    found = {}
    for field, value in flat(settled).items():
        if field in known and (field not in _WHOLE or known[field].against):
            found[field] = _of_field(known[field], value)
        elif field not in _WHOLE:  # of a vehicle or a contact that the answer does not have
            reason = f"{READER}'s, which was kept to in how many there are"
            theirs = read.get(field, FieldEvidence(value, None, TRUST[READER], ""))
            found[field] = replace(theirs, value=value, reason=reason)
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
