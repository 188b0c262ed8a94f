"""What the reader finds that a vehicle struck, with which side, and where that stood."""

import pytest

from roadmend.safe.dsl import Side, StruckObject
from roadmend.safe.reading.reader import read_summary

ALONE = "This single-vehicle crash happened on a two-lane road. V1, a 2012 Honda Civic sedan, was traveling south."


def impacts(text, before=ALONE):
    return read_summary(f"{before} {text}").scenario.impacts


@pytest.mark.parametrize(
    ("text", "thing", "side", "roadside"),
    [
        (
            "V1 departed the right side of the road and struck a utility pole with its left side.",
            "Pole",
            "Left",
            "Right",
        ),
        (
            "V1 departed the road to the left. V1 then struck a 36 cm diameter tree with its front.",
            "Tree",
            "Front",
            "Left",
        ),
        ("V1 departed the west road edge before impacting a utility pole with its left side.", "Pole", "Left", "Right"),
        ("V1 drifted onto the left roadside. V1 struck a guardrail with its front.", "Barrier", "Front", "Left"),
        ("V1 left the roadway on the east side and struck a mailbox.", "Sign", None, "Left"),
        ("V1 traveled off the right side of the road into a curb (Event 1).", "Curb", None, "Right"),
        ("V1 ran off the road and entered a ditch (Event 1).", "Ditch", None, None),
        ("A large deer entered the road. V1 struck the deer with its front.", "Animal", "Front", None),
        ("V1 struck a brick wall.", "Wall", None, None),
        ("V1 struck a boulder.", "Other", None, None),
    ],
)
def test_what_was_struck(text, thing, side, roadside):
    (impact,) = impacts(text)
    assert impact.object is StruckObject(thing)
    assert impact.striking_side is (side and Side(side))
    assert impact.roadside is (roadside and Side(roadside))


def test_the_first_of_several_counts_and_what_sums_up_comes_last():
    told = "This case involves a Honda Civic that struck a tree. V1 departed the right side of the road."
    (impact,) = impacts("V1 struck a sign with its front and then a tree with its left side.", f"{ALONE} {told}")
    assert (impact.object, impact.roadside) == (StruckObject.SIGN, Side.RIGHT)
    (impact,) = impacts("", f"{ALONE} {told}")
    assert impact.object is StruckObject.TREE


def test_a_part_of_a_thing_is_none_of_the_other_vehicle():
    text = (
        "This single-vehicle crash happened on a road that was wide enough for two vehicles. V1, a Honda sedan, was "
        "traveling west. V1 departed the left side of the road to a lot, where semi-trailers were parked. V1 struck the "
        "underside edge of the trailer with its left door."
    )
    scenario = read_summary(text).scenario
    assert len(scenario.vehicles) == 1
    assert scenario.impacts[0].object is StruckObject.PARKED_TRAILER


def test_an_edge_that_is_named_by_the_compass_needs_a_direction():
    nowhere = "This single-vehicle crash happened at night. V1, a sedan, departed the west road edge and struck a tree."
    (impact,) = read_summary(nowhere).scenario.impacts
    assert impact.roadside is None


@pytest.mark.parametrize("text", ["V1 avoided the tree and struck nothing.", "V1 rolled over.", "V1 missed a pole."])
def test_nothing_struck(text):
    assert impacts(text) == ()


def test_where_vehicles_touched_that_is_the_crash():
    pair = "V1, a Honda Civic, was traveling north. V2, a Ford F-150, was traveling south."
    assert impacts("V1 struck V2 and then a tree.", pair) == ()


def test_each_field_says_what_it_rests_on():
    reading = read_summary(f"{ALONE} V1 departed the right side of the road and struck a tree with its front.")
    fields = {name: found for name, found in reading.findings.items() if name.startswith("impacts")}
    assert [*fields] == ["impacts[0].object", "impacts[0].striking_side", "impacts[0].roadside"]
    assert all(found.confidence > 0.8 and found.claims[0].where is not None for found in fields.values())
