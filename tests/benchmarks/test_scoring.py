"""Extractions against oracles, field by field; the same by somebody else's tool where there is one, in SCORING_TOOL."""

import json
import os
import random
import subprocess
import sys
from pathlib import Path

import pytest

from harness.scoring import calibrate, load_oracles, majority, mark, oracles_of_records, score
from roadmend.core.errors import InputError
from roadmend.safe.dsl_data import dump_data
from tests.safe.crashes import ALL, CROSSING

TOOL = Path(os.environ.get("SCORING_TOOL") or Path(__file__).parents[3] / "shared" / "tools" / "score_extraction.py")


@pytest.fixture
def measure():
    def run(change=lambda oracle: None, reading=None, *, text_only=False):
        oracle = json.loads(json.dumps(dump_data(CROSSING)))
        change(oracle)
        readings = {"c": dump_data(CROSSING) if reading is None else reading, "other": dump_data(CROSSING)}
        return score(readings, {"c": oracle}, text_only=text_only)

    return run


def test_all_right(measure):
    found = measure()
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
def test_one_wrong_field_spoils_its_category_and_the_whole(measure, change, wrong):
    found = measure(change)
    assert {name for name in ("road", "actors", "env") if getattr(found, name) == 0.0} == {wrong}
    assert found.overall == 0.0


def test_what_is_open_is_not_asked_and_alternatives_are_right(measure):
    assert measure(lambda oracle: oracle.update(num_lanes=None)).overall == 100.0
    assert measure(lambda oracle: oracle.update(num_lanes=6, alternatives={"num_lanes": [2]})).overall == 100.0
    assert measure(lambda oracle: oracle.update(stem_direction=None)).overall == 100.0


def test_without_the_sketch_less_is_asked(measure):
    def change(oracle):
        oracle["vehicles"][0]["speed_limit_mph"] = 70
        oracle["text_only_overrides"] = {"vehicles[0].speed_limit_mph": None}

    assert measure(change).actors == 0.0
    assert measure(change, text_only=True).actors == 100.0


def test_a_stem_where_there_is_none_and_a_report_that_was_not_read_are_wrong():
    reading = dump_data(CROSSING) | {"stem_direction": "North"}
    assert mark(reading, dump_data(CROSSING), text_only=False)["stem_direction"] is False
    assert not any(mark(None, dump_data(CROSSING), text_only=False).values())
    assert score({}, {"c": dump_data(CROSSING)}, text_only=False) is None


def test_oracles_are_found_beside_reports_beside_texts_and_in_records(tmp_path):
    oracle = json.dumps(dump_data(CROSSING))
    (tmp_path / "one").mkdir()
    (tmp_path / "one" / "oracle.json").write_text(oracle, encoding="utf-8")
    (tmp_path / "two.oracle.json").write_text(oracle, encoding="utf-8")
    assert {*load_oracles(tmp_path)} == {"one", "two"}
    (tmp_path / "records").mkdir()
    (tmp_path / "records" / "three.json").write_text(f'{{"oracle": {oracle}}}', encoding="utf-8")
    (tmp_path / "records" / "four.json").write_text('{"oracle": null}', encoding="utf-8")
    assert {*oracles_of_records(tmp_path / "records")} == {"three"}


@pytest.mark.parametrize("content", ["[]", "{}", '{"vehicles": [], "env": {}}', "no json"])
def test_a_damaged_oracle_is_named(tmp_path, content):
    (tmp_path / "one.oracle.json").write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match=r"one\.oracle\.json"):
        load_oracles(tmp_path)


def test_confidence_is_held_against_what_is_right():
    table = calibrate([(0.95, True), (0.95, False), (1.0, True), (0.6, False)])
    assert [(each.low, each.count, each.right) for each in table if each.count] == [(0.5, 1, 0.0), (0.9, 3, 0.667)]


def test_the_trivial_reader_gives_the_usual_values():
    usual = majority([dump_data(ALL[name]) for name in ("straight", "rear end", "intersection")])
    assert (usual["road_type"], usual["stem_direction"], len(usual["vehicles"])) == ("Straight", None, 2)
    assert {vehicle["action"] for vehicle in usual["vehicles"]} == {"Move Forward"}


@pytest.mark.skipif(not TOOL.is_file(), reason="SCORING_TOOL names no other tool that scores")
def test_the_shared_tool_gives_the_same_scores(tmp_path):
    numbers = random.Random(7)
    right, read = {}, {}
    for case in range(30):
        oracle = json.loads(json.dumps(dump_data(numbers.choice([*ALL.values()]))))
        reading = json.loads(json.dumps(oracle))
        if numbers.random() < 0.5:
            reading["vehicles"][0]["model"] = "Pickup"
        if numbers.random() < 0.3:
            reading["num_lanes"] = 8
        if numbers.random() < 0.3:
            oracle["alternatives"] = {"num_lanes": [8], "env.weather": ["sunny"]}
        if numbers.random() < 0.3:
            oracle["text_only_overrides"] = {"vehicles[0].model": None, "stem_direction": None}
        if numbers.random() < 0.2:
            reading["env"]["weather"] = "Sunny"
        right[f"c{case}"], read[f"c{case}"] = oracle, None if numbers.random() < 0.1 else reading
    for folder, content in (("oracles", right), ("readings", read)):
        for case, data in content.items():
            (tmp_path / folder / case).mkdir(parents=True)
            name = "oracle.json" if folder == "oracles" else "scenario.json"
            if data is not None:
                (tmp_path / folder / case / name).write_text(json.dumps(data), encoding="utf-8")
    for text_only in (False, True):
        command = [sys.executable, TOOL, tmp_path / "readings", tmp_path / "oracles", "--json"]
        told = subprocess.run([*command, *(["--text-only"] if text_only else [])], capture_output=True, check=True)
        theirs, ours = json.loads(told.stdout), score(read, right, text_only=text_only)
        assert [theirs[name] for name in ("cases", "road", "actors", "env", "overall")] == [
            getattr(ours, name) for name in ("cases", "road", "actors", "env", "overall")
        ]
