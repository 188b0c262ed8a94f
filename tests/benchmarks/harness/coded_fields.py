"""Records made by hand held against the fields that an investigation coded, where a report has them."""

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from roadmend.core.errors import InputError
from roadmend.safe.contact import Part
from roadmend.safe.crash_record import CrashRecord, RecordedVehicle

CODED = "nhtsa_coded.json"
_TURNS = {"turning left": 90.0, "turning right": -90.0, "going straight": 0.0, "negotiating a curve": 0.0}
_STOOD = ("stopped", "parked")
_ANGLE = 50.0  # [deg]
_AT_JUNCTION = ("Intersection", "T-intersection")


@dataclass(frozen=True, slots=True)
class CrossCheck:
    """What the coded fields say of a record.

    Attributes:
        checked: statements that both make.
        contradicted: those in which they differ, in words.
    """

    checked: int
    contradicted: tuple[str, ...]


def cross_check(record: CrashRecord, report: Path) -> CrossCheck | None:
    """Compare a record with the coded fields in a report's folder; None where it has none.

    Raises:
        InputError: they are broken.
    """
    path = report / CODED
    if not path.is_file():
        return None
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        statements = list(_statements(record, content))
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise InputError(str(path), "holds no coded fields", "leave the file out, or mend it") from None
    return CrossCheck(len(statements), tuple(words for words, agrees in statements if not agrees))


def _statements(record: CrashRecord, content: Mapping[str, Any]) -> Iterator[tuple[str, bool]]:
    for coded in content["vehicles"]:
        vehicle = record.vehicle(int(coded["vehicle_number"]))
        yield from _of_vehicle(vehicle, str(coded.get("pre_event_movement") or "").lower())
    relations = " ".join(str(coded.get("relation_to_junction") or "").lower() for coded in content["vehicles"])
    if record.roads and relations.strip():
        coded_there = "intersection" in relations
        if "driveway" not in relations and ("non-" not in relations or coded_there):
            told_there = any(road in _AT_JUNCTION for road in record.roads)
            yield "at a junction", told_there or not coded_there
    configuration = str(content.get("configuration") or "").lower()
    if record.collisions:
        first = record.collisions[0]
        parts = (first.striking_part, first.struck_part)
        if "rear" in configuration and None not in parts:
            yield "rear end", any(part is not None and part.is_near(Part.REAR) for part in parts)
        if "head" in configuration and None not in parts:
            yield "head-on", all(part is not None and part.is_near(Part.FRONT) for part in parts)


def _of_vehicle(vehicle: RecordedVehicle, movement: str) -> Iterator[tuple[str, bool]]:
    if movement.startswith(_STOOD):
        yield f"vehicle {vehicle.number} stood", vehicle.stands
    turn = _TURNS.get(movement)
    if turn is not None and vehicle.origin is not None and vehicle.destination is not None:
        turned = math.remainder(vehicle.destination - vehicle.origin, 360.0)
        yield f"vehicle {vehicle.number} {movement}", abs(math.remainder(turned - turn, 360.0)) <= _ANGLE
