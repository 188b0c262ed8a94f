"""A record is held against what an investigation coded."""

import json

import pytest

from harness.coded_fields import cross_check
from roadmend.core.errors import InputError
from roadmend.safe.contact import Part
from roadmend.safe.crash_record import CrashRecord, RecordedCollision, RecordedManoeuvre, RecordedVehicle

RECORD = CrashRecord(
    "c",
    ("Intersection",),
    (RecordedVehicle(1, 0.0, 90.0, RecordedManoeuvre.TURN_LEFT), RecordedVehicle(2, 180.0, 180.0)),
    (RecordedCollision(2, 1, Part.FRONT, Part.RIGHT),),
)


def check(tmp_path, configuration, *movements, relation="Intersection"):
    vehicles = [
        {"vehicle_number": number, "pre_event_movement": movement, "relation_to_junction": relation}
        for number, movement in enumerate(movements, 1)
    ]
    content = {"configuration": configuration, "vehicles": vehicles}
    (tmp_path / "nhtsa_coded.json").write_text(json.dumps(content), encoding="utf-8")
    return cross_check(RECORD, tmp_path)


def test_what_agrees_and_what_does_not(tmp_path):
    assert check(tmp_path, "Angle/sideswipe", "Turning left", "Going straight") == type(
        check(tmp_path, None, "Unknown", None)
    )(3, ())
    other = check(tmp_path, "Rear end", "Turning right", "Stopped in traffic lane", relation="Non-junction")
    assert other.contradicted == ("vehicle 1 turning right", "vehicle 2 stood", "rear end")


def test_without_coded_fields_there_is_nothing_to_say_and_broken_ones_are_named(tmp_path):
    assert cross_check(RECORD, tmp_path) is None
    (tmp_path / "nhtsa_coded.json").write_text("[]", encoding="utf-8")
    with pytest.raises(InputError, match="coded"):
        cross_check(RECORD, tmp_path)
