"""Crashes told plainly, by the rules alone: who strikes whom, who stands, and what a number is of."""

from pathlib import Path

import pytest
import yaml

from roadmend.safe.dsl_data import dump_data
from roadmend.safe.reading.limits import possible_limits
from roadmend.safe.reading.reader import read_claims, read_summary

CRASHES = yaml.safe_load((Path(__file__).parent / "plain_crashes.yaml").read_text())
VEHICLE = ("model", "initial_position", "action", "manoeuvre", "speed_limit_mph")
CONTACT = ("striking", "struck", "striking_side", "struck_side")


def fits(found, names, wanted):
    return all(value is None or found.get(name) == value for name, value in zip(names, wanted, strict=True))


@pytest.mark.parametrize("crash", CRASHES, ids=[each["text"][:50] for each in CRASHES])
def test_a_crash_told_plainly(crash):
    data = dump_data(read_summary(crash["text"]).scenario)
    vehicles, contacts = data["vehicles"], data.get("collisions", [])
    assert (len(vehicles), len(contacts)) == (len(crash["vehicles"]), len(crash["contacts"]))
    for found, wanted in zip(vehicles, crash["vehicles"], strict=True):
        assert fits(found, VEHICLE, wanted), (found, wanted)
    for found, wanted in zip(contacts, crash["contacts"], strict=True):
        assert fits(found, CONTACT, wanted), (found, wanted)


@pytest.mark.parametrize(
    ("text", "mph", "others"),
    [
        ("V1 was eastbound on US-40 at 60 mph and struck V2.", set(), {40, 60}),
        ("V1 was eastbound on Route 50 and struck V2. It is a 45.", {45}, {50}),
        ("V1 was eastbound and struck V2. Sign C13: 70.", {70, 43}, {60}),
        ("V1 was eastbound and struck V2, and its THIRTY FIVE there.", {35}, {60}),
    ],
)
def test_which_numbers_may_be_limits(text, mph, others):
    found = possible_limits(read_claims(text).text)
    assert found >= mph
    assert not found & others
