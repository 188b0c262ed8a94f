"""Directions that nobody states and that follow from how one vehicle stands to another, or a road to a vehicle."""

from pathlib import Path

import pytest
import yaml

from roadmend.safe.dsl_data import dump_data
from roadmend.safe.reading.reader import read_summary

TOLD = yaml.safe_load((Path(__file__).parent / "told_relations.yaml").read_text())


def read(case):
    return dump_data(read_summary(case["text"]).scenario)


def marked(case):
    """Those with "misread" are not yet read right; who mends one takes the mark away, or its test fails."""
    marks = [pytest.mark.xfail(strict=True)] if case.get("misread") else []
    return pytest.param(case, id=case["text"][:40], marks=marks)


@pytest.mark.parametrize("case", list(map(marked, TOLD["ways"])))
def test_the_way_of_the_one_follows_from_the_other(case):
    assert [vehicle["initial_position"] for vehicle in read(case)["vehicles"]] == case["vehicles"]


@pytest.mark.parametrize("case", list(map(marked, TOLD["roads"])))
def test_the_road_and_the_turns(case):
    data = read(case)
    assert [data["road_type"], data["stem_direction"]] == case["road"]
    assert len(data["vehicles"]) == len(case["vehicles"])
    for vehicle, wanted in zip(data["vehicles"], case["vehicles"], strict=True):
        found = [vehicle[name] for name in ("model", "initial_position", "action")]
        assert all(each is None or one == each for one, each in zip(found, wanted, strict=True)), (found, wanted)


def test_relations_are_many():
    """Each kind is there: same, opposite, crossing from either side."""
    pairs = {frozenset(case["vehicles"]) for case in TOLD["ways"]}
    assert {frozenset({"E2W", "W2E"}), frozenset({"N2S", "S2N"}), frozenset({"E2W"})} <= pairs


def test_nobody_calls_himself_he():
    text = "I drove my Corolla out on Pulaski Road and met a Camry nose to nose. He was westbound."
    assert [vehicle["initial_position"] for vehicle in read({"text": text})["vehicles"]] == ["W2E", "E2W"]


def test_what_a_road_does_is_done_by_no_vehicle():
    text = "A Ford Explorer, northbound on 12, hit a southbound van. Lodge Road begins at Route 12 and runs west to the lake."
    assert [vehicle["initial_position"] for vehicle in read({"text": text})["vehicles"]] == ["S2N", "N2S"]
