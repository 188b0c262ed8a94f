"""Records of crashes are read strictly; what is null is not known."""

import json

import pytest

from roadmend.core.errors import InputError
from roadmend.safe.contact import Part
from roadmend.safe.crash_record import RecordedImpact, RecordedThing, load_record, load_records

CRASH = {
    "road": "Intersection",
    "vehicles": [
        {"number": 1, "from": "W", "to": "S", "manoeuvre": "turn left"},
        {"number": 2, "from": "N", "to": None, "manoeuvre": "parked"},
    ],
    "collisions": [
        {"striking": 2, "struck": 1, "striking_part": "front", "struck_part": "rear-left"},
        {"striking": 1, "struck": "object: tree", "striking_part": "front", "struck_part": None},
    ],
    "doubt": "none",
}


@pytest.fixture
def load(tmp_path):
    def run(oracle=None, **changes):
        content = {"case": "a", "crash": CRASH | changes, "annotator": "somebody", "oracle": oracle}
        (tmp_path / "a.json").write_text(json.dumps(content), encoding="utf-8")
        return load_record(tmp_path / "a.json")

    return run


def test_a_record_is_read(load, tmp_path):
    record = load()
    assert (record.case, record.roads, record.events) == ("a", ("Intersection",), 2)
    assert [(each.origin, each.destination) for each in record.vehicles] == [(180.0, 270.0), (90.0, None)]
    assert [each.stands for each in record.vehicles] == [False, True]
    (collision,) = record.collisions
    assert (collision.striking, collision.struck) == (2, 1)
    assert (collision.striking_part, collision.struck_part) == (Part.FRONT, Part.REAR_LEFT)
    assert record.impacts == (RecordedImpact(1, Part.FRONT, RecordedThing.UPRIGHT, on_roadway=False),)
    assert not record.is_alone
    assert load_records(tmp_path) == {"a": record}
    assert record.vehicle(7).origin is None


@pytest.mark.parametrize(
    ("words", "thing", "on_roadway"),
    [
        ("object: large deer", RecordedThing.ON_THE_ROADWAY, True),
        ("pedestrian", RecordedThing.ON_THE_ROADWAY, True),
        ("object: parked semi-trailer", RecordedThing.VEHICLE, False),
        ("object: guardrail end", RecordedThing.ALONG_THE_ROAD, False),
        ("object: utility pole", RecordedThing.UPRIGHT, False),
        ("object: horse trailer", RecordedThing.VEHICLE, False),
        ("object: horses", RecordedThing.ON_THE_ROADWAY, True),
        ("object: dogwood tree", RecordedThing.UPRIGHT, False),
        ("dogs", RecordedThing.ON_THE_ROADWAY, True),
        ("bicycle", RecordedThing.ON_THE_ROADWAY, True),
        ("cyclist", RecordedThing.ON_THE_ROADWAY, True),
        ("object: parked cars", RecordedThing.VEHICLE, False),
        ("object: fallen cargo", None, None),
        ("object: cardboard box", None, None),
        ("object: something", None, None),
    ],
)
def test_words_tell_what_was_struck_and_where(load, words, thing, on_roadway):
    record = load(
        collisions=[{"striking": 2, "struck": words, "striking_part": "left"}, {"striking": 2, "struck": None}]
    )
    assert record.is_alone
    assert record.impacts == (RecordedImpact(2, Part.LEFT, thing, on_roadway),)
    assert record.events == 2


def test_who_ran_off_the_road_struck_something_beside_it(load):
    vehicles = [{"number": 1, "manoeuvre": "run off road"}, {"number": 2, "manoeuvre": "drift left"}]
    struck = [{"striking": 1, "struck": "object: something"}]
    record = load(vehicles=vehicles, collisions=struck)
    assert record.impacts[0].on_roadway is False
    assert [each.leaves for each in record.vehicles] == [0, 1]


def test_a_road_may_have_a_stem_and_alternatives(load):
    record = load(oracle={"alternatives": {"road_type": ["Straight"]}}, road="T-intersection", stem="W")
    assert (record.roads, record.stem) == (("T-intersection", "Straight"), 180.0)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"road": "Roundabout"}, "crash.road"),
        ({"vehicles": [{"number": 0}]}, "number"),
        ({"vehicles": [{"number": 1}, {"number": 1}]}, "two vehicles"),
        ({"vehicles": [{"number": 1, "from": "up"}]}, "from"),
        ({"vehicles": "two"}, "vehicles"),
        ({"vehicles": [{"number": 1, "manoeuvre": "backing out"}]}, "manoeuvre"),
        ({"vehicels": []}, "vehicels"),
        ({"collisions": [{"striking": 1, "struck": 1}]}, "itself"),
        ({"collisions": [{"striking": 1, "struck": "2"}]}, "'2' would be an object"),
        ({"collisions": [{"striking": " V 2", "struck": 1}]}, "a vehicle is its number alone"),
        ({"collisions": [{"striking": 1, "struck": 22}]}, "collision 1 is of vehicle 22"),
        ({"collisions": [{"striking": 1, "struck": 2, "striking_part": "antenna"}]}, "striking_part"),
        ({"collisions": [{"striking": 1, "struck": 2, "striking_part": "front-rear"}]}, "striking_part"),
    ],
)
def test_what_is_none_is_refused_with_its_place(load, changes, words):
    with pytest.raises(InputError, match=words):
        load(**changes)


@pytest.mark.parametrize("roads", [[None], ["Roundabout"], "Straight"])
def test_an_alternative_that_is_no_road_is_refused(load, roads):
    with pytest.raises(InputError, match=r"oracle\.alternatives\.road_type"):
        load(oracle={"alternatives": {"road_type": roads, "env.weather": ["Clear"]}})


def test_a_folder_without_records_is_refused(tmp_path):
    with pytest.raises(InputError, match="no crash records"):
        load_records(tmp_path)
