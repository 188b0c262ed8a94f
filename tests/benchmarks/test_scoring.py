"""Extractions against oracles, field by field."""

import json
from dataclasses import replace

import pytest

from harness.scoring import score_cases
from roadmend.core.errors import InputError
from roadmend.safe.cases import CrashCase
from roadmend.safe.dsl import Compass, DescribedRoadNetwork, RoadType
from roadmend.safe.dsl_data import dump_data
from tests.safe.crashes import CROSSING


@pytest.fixture
def score(tmp_path):
    def run(change=lambda oracle: None, crash=CROSSING, *, text_only=False):
        oracle = json.loads(json.dumps(dump_data(CROSSING)))
        change(oracle)
        (tmp_path / "c").mkdir(exist_ok=True)
        (tmp_path / "c" / "oracle.json").write_text(json.dumps(oracle), encoding="utf-8")
        return score_cases([CrashCase("c", crash), CrashCase("other", CROSSING)], tmp_path, text_only=text_only)

    return run


def test_all_right(score):
    found = score()
    assert (found.cases, found.road, found.actors, found.env, found.overall) == (1, 100.0, 100.0, 100.0, 100.0)


@pytest.mark.parametrize(
    ("change", "wrong"),
    [
        (lambda oracle: oracle.update(num_lanes=6), "road"),
        (lambda oracle: oracle["vehicles"][1].update(model="Pickup"), "actors"),
        (lambda oracle: oracle["vehicles"].append(dict(oracle["vehicles"][0])), "actors"),
        (lambda oracle: oracle["env"].update(weather="Rainy"), "env"),
    ],
)
def test_one_wrong_field_spoils_its_category_and_the_whole(score, change, wrong):
    found = score(change)
    assert {name: getattr(found, name) for name in ("road", "actors", "env")} == {
        name: 0.0 if name == wrong else 100.0 for name in ("road", "actors", "env")
    }
    assert found.overall == 0.0


def test_alternatives_and_fields_that_nobody_can_tell_are_right(score):
    def change(oracle):
        oracle["vehicles"][0]["model"] = "SUV"
        oracle["env"]["time"] = None
        oracle["alternatives"] = {"vehicles[0].model": ["Sedan"]}

    assert score(change).overall == 100.0


def test_overrides_count_for_the_text_alone(score):
    def change(oracle):
        oracle["num_lanes"] = 6
        oracle["text_only_overrides"] = {"num_lanes": 2}

    assert score(change).road == 0.0
    assert score(change, text_only=True).road == 100.0


def test_a_field_that_an_oracle_does_not_have_is_not_counted(score):
    def change(oracle):
        del oracle["num_lanes"], oracle["vehicles"][0]["speed_limit_mph"]

    assert score(change).overall == 100.0


STEM = DescribedRoadNetwork(RoadType.T_INTERSECTION, CROSSING.road.lanes, Compass.EAST)


@pytest.mark.parametrize(
    ("oracle_road", "oracle_stem", "crash_road", "right"),
    [
        ("T-intersection", "East", STEM, True),
        ("T-intersection", "North", STEM, False),
        ("T-intersection", None, STEM, True),  # nobody can tell where it lies
        ("Intersection", None, STEM, False),  # there is none
    ],
)
def test_a_stem_counts_where_the_oracle_has_one_or_knows_that_there_is_none(
    score, oracle_road, oracle_stem, crash_road, right
):
    def change(oracle):
        oracle |= {"road_type": oracle_road, "stem_direction": oracle_stem, "alternatives": {"road_type": [*RoadType]}}

    assert score(change, replace(CROSSING, road=crash_road)).road == (100.0 if right else 0.0)


def test_what_could_not_be_read_is_wrong_everywhere(score):
    found = score(crash=None)
    assert (found.road, found.actors, found.env, found.overall) == (0.0, 0.0, 0.0, 0.0)


def test_without_oracles_there_is_no_score_and_a_damaged_one_is_an_error(tmp_path):
    assert score_cases([CrashCase("c", CROSSING)], tmp_path, text_only=True) is None
    (tmp_path / "c").mkdir()
    for damaged, said in (
        ('{"vehicles": 3}', "is no oracle"),
        ('["vehicles"]', "is no oracle"),
        ('{"vehicles": [], "env": {}}', "names no field"),
    ):
        (tmp_path / "c" / "oracle.json").write_text(damaged, encoding="utf-8")
        with pytest.raises(InputError, match=said):
            score_cases([CrashCase("c", CROSSING)], tmp_path, text_only=True)
