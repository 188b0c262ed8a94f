"""The reader on crashes in the words of many kinds of writers; every field has to be right.

Those with "misread" are not yet read right; who mends one takes the mark away, or its test fails.
"""

from pathlib import Path

import pytest
import yaml

from roadmend.safe.dsl_data import dump_data
from roadmend.safe.reading.reader import read_summary

FOLDER = Path(__file__).parent
CASES = [
    case
    for name in ("written_crashes", "retold_crashes")
    for case in yaml.safe_load((FOLDER / f"{name}.yaml").read_text())
]
OPEN = "none"


def fits(found, wanted):
    return wanted is None or found == (None if wanted == OPEN else wanted)


def marked(case):
    marks = [pytest.mark.xfail(strict=True)] if case.get("misread") else []
    return pytest.param(case, id=case["text"][:40], marks=marks)


@pytest.mark.parametrize("case", list(map(marked, CASES)))
def test_a_crash_in_other_words(case):
    reading = read_summary(case["text"])
    data = dump_data(reading.scenario)
    road_type, lanes, stem = case["road"]
    assert fits(data["road_type"], road_type)
    assert fits(data["num_lanes"], lanes)
    assert data["stem_direction"] == stem or road_type is None
    found = [
        [vehicle[name] for name in ("model", "initial_position", "action", "speed_limit_mph")]
        for vehicle in data["vehicles"]
    ]
    assert len(found) == len(case["vehicles"])
    for one, wanted in zip(found, case["vehicles"], strict=True):
        assert all(map(fits, one, wanted)), (one, wanted)
    assert all(map(fits, (data["env"]["time"], data["env"]["weather"]), case["env"]))


def test_most_are_read_right():
    assert sum(bool(case.get("misread")) for case in CASES) < 0.2 * len(CASES)


def test_the_same_text_is_read_the_same_way():
    text = CASES[0]["text"]
    assert read_summary(text) == read_summary(text)
