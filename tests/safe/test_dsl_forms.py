"""The three written forms of a scenario: what is written is read back, and mistakes are named by line and field."""

import json
import tracemalloc
from datetime import date

import pytest
from hypothesis import given, settings

from roadmend.core.errors import InputError
from roadmend.safe.dsl import Compass, DescribedImpact, RoadType, Side, StruckObject
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.dsl_file import dump_crash_scenario, load_crash_scenario, parse_crash_scenario, save_crash_scenario

from .scenarios import scenarios

FORMS = (".json", ".yaml", ".txt")
LISTING = """\
<Scenario>:
  <Road network>:
    <Road type>: T-intersection
    <No. lanes>: 3
    <Stem direction>: West
  <Actors>:
    <Vehicle_1>:
      <Model>: Sedan
      <Initial_position>: W2E
      <Actions>: Turn Left
      <Speed_limit>: 45
    <Vehicle_2>:
      <Model>: SUV
      <Initial_position>: N2S
      <Actions>: [[0, 0], [12.5, 3]]
      <Speed_limit>: Unknown
      <x-colour>: "red"
  <Env>:
    <Time>: Nighttime
    <Weather>: Clear
"""


@pytest.mark.parametrize("form", FORMS)
@given(scenario=scenarios())
@settings(max_examples=60, deadline=None)
def test_what_is_written_is_read_back(form, scenario):
    assert parse_crash_scenario(dump_crash_scenario(scenario, form), form, "here") == scenario


def test_the_listing_of_the_paper_reads():
    scenario = parse_crash_scenario(LISTING, ".txt", "listing")
    assert (scenario.road.road_type, scenario.road.lanes, scenario.road.stem) == (
        RoadType.T_INTERSECTION,
        3,
        Compass.WEST,
    )
    assert scenario.vehicles[1].action == ((0.0, 0.0), (12.5, 3.0))
    assert scenario.vehicles[1].speed_limit_mph is None
    assert scenario.vehicles[1].extras == {"x-colour": "red"}


def test_what_was_struck_reads():
    impact = (
        "<Impacts>:\n    <Impact_1>:\n      <Striking>: 2\n      <Object>: Parked Trailer\n      <Roadside>: Left\n"
    )
    scenario = parse_crash_scenario(f"{LISTING}  {impact}", ".txt", "listing")
    assert scenario.impacts == (DescribedImpact(2, StruckObject.PARKED_TRAILER, None, Side.LEFT),)
    assert dump_data(scenario)["impacts"] == [{"striking": 2, "object": "Parked Trailer", "roadside": "Left"}]


def test_not_applicable_is_no_stem():
    text = LISTING.replace("T-intersection", "Curve").replace("West", "Not applicable")
    assert parse_crash_scenario(text, ".txt", "listing").road.stem is None
    data = dump_data(parse_crash_scenario(LISTING, ".txt", "listing"))
    data |= {"road_type": "Intersection", "stem_direction": "Not applicable"}
    assert parse_data(data, "here").road.stem is None


def test_files(tmp_path):
    scenario = parse_crash_scenario(LISTING, ".txt", "listing")
    for form in FORMS:
        save_crash_scenario(scenario, tmp_path / f"case{form}")
        assert load_crash_scenario(tmp_path / f"case{form}") == scenario
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(f"case{form}" for form in FORMS)
    with pytest.raises(InputError, match="no such file"):
        load_crash_scenario(tmp_path / "missing.json")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        save_crash_scenario(scenario, tmp_path / "file" / "case.json")


MISTAKES = [  # what is put in the place of what, and what the error says: line, field
    ("<No. lanes>: 3", "<No. lanes>: many", 4, "No. lanes"),
    ("<No. lanes>: 3", "<No. lanes>: 3.5", 4, "num_lanes"),
    ("<No. lanes>: 3", "<No. lanes>: 0", 4, "num_lanes"),
    ("<No. lanes>: 3", "<No. lanes>:", 4, "No. lanes"),
    ("<No. lanes>: 3", "<Lanes>: 3", 4, "Lanes"),
    ("<No. lanes>: 3", "no lanes", 4, "no lanes"),
    ("    <No. lanes>: 3\n", "", 2, "num_lanes"),
    ("T-intersection", "Roundabout", 3, "road_type"),
    ("T-intersection", "Curve", 5, "stem_direction"),
    ("Sedan", "Car", 8, "vehicles[0].model"),
    ("W2E", "Main road", 9, "vehicles[0].initial_position"),
    ("Turn Left", "Fly", 10, "vehicles[0].action"),
    ("45", "500", 11, "vehicles[0].speed_limit_mph"),
    ("45", "NaN", 11, "vehicles[0].speed_limit_mph"),
    ("<Vehicle_2>", "<Vehicle_3>", 12, "Vehicle_3"),
    ("[[0, 0], [12.5, 3]]", "[[0, 0], [12.5]]", 15, "vehicles[1].action[1]"),
    ("[[0, 0], [12.5, 3]]", "[[0, 0]]", 15, "vehicles[1].action"),
    ("<x-colour>", "<colour>", 17, "colour"),
    ("<Time>: Nighttime", "<Time>: Nighttime\n    <Time>: Daytime", 20, "Time"),
    ("  <Env>:", "  <Weather report>:", 18, "Weather report"),
    ("<Road network>:", "<Road network>: 7", 2, "Road network"),
    ("<Scenario>:", "<Scenario>: whatever", 1, "Scenario"),
    ("<Actors>:", "<Actors>: two", 6, "Actors"),
    ("  <Env>:", "  <Collisions>: vehicle 1 ran into vehicle 2\n  <Env>:", 18, "Collisions"),
    ("  <Env>:", "  <Impacts>: 1\n  <Env>:", 18, "Impacts"),
    ("  <Env>:", "  <x-note>: 1\n    <more>: 2\n  <Env>:", 19, "more"),
    ("Sedan", "Not applicable", 8, "vehicles[0].model"),
    ("<Speed_limit>: 45", "<Speed_limit>: Not applicable", 11, "Speed_limit"),
    ("<Weather>: Clear", "<Weather>: Not applicable", 20, "env.weather"),
]


@pytest.mark.parametrize(
    ("old", "new", "line", "field"), MISTAKES, ids=[f"{new or 'nothing'}" for _, new, _, _ in MISTAKES]
)
def test_the_text_form_names_line_and_field(old, new, line, field):
    assert old in LISTING
    with pytest.raises(InputError) as caught:
        parse_crash_scenario(LISTING.replace(old, new, 1), ".txt", "case")
    assert caught.value.where == f"case, line {line}"
    assert field in caught.value.what


@pytest.mark.parametrize(
    ("field", "good", "broken"),
    [
        ("x-bend", ["left", "Right", None], ["up", 7, True]),
        ("x-median", [0, 6.5, 60, True, False, None], [-1, 61, float("nan"), "6 m"]),
        ("x-divided", [True, False, None], ["yes", 1]),
        ("x-control", ["signal", "All-way stop", "none", None], ["traffic signal", 4]),
        ("x-heading", ["North", "west", None], ["N2S", 90]),
        ("x-lane", [1, 3, "left", "Middle", None], [0, -1, 1.5, True, "second"]),
    ],
)
def test_fields_of_ones_own_that_roads_are_built_by_hold_what_that_asks_for(field, good, broken):
    def parse(value):
        data = dump_data(parse_crash_scenario(LISTING, ".txt", "listing"))
        place = data["vehicles"][1] if field == "x-lane" else data
        place[field] = value
        return parse_data(data, "here")

    for value in good:
        parse(value)
    for value in broken:
        with pytest.raises(
            InputError, match=rf"here: field (vehicles\[1\]\.)?{field}: .* is not what a road is built by"
        ):
            parse(value)
    elsewhere = changed(env=changed()["env"] | {field: broken[0]})
    assert parse_data(elsewhere, "here").environment.extras == {field: broken[0]}


@pytest.mark.parametrize("text", ["", "<Road network>:\n", LISTING + LISTING])
def test_a_text_is_one_scenario(text):
    with pytest.raises(InputError, match="one <Scenario>"):
        parse_crash_scenario(text, ".txt", "case")


def changed(**changes):
    return dump_data(parse_crash_scenario(LISTING, ".txt", "listing")) | changes


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ([], "not fields"),
        (changed(wether="Clear"), "field wether: is none of"),
        (changed(env={"time": None}), "field env.weather: is missing"),
        (changed(vehicles=[]), "vehicles"),
        (changed(vehicles="none"), "field vehicles: is .*not a list"),
        (changed(vehicles=[3]), r"field vehicles\[0\]"),
        (changed(num_lanes=True), "field num_lanes: true is no number"),
        (changed(num_lanes="3"), "field num_lanes"),
        (changed(stem_direction="Up"), "field stem_direction"),
        (changed(collisions=[{"striking": 1}]), r"field collisions\[0\].struck: is missing"),
        (changed(collisions=[{"striking": 1, "struck": None}]), r"field collisions\[0\]"),
        (changed(collisions=[{"striking": 1, "struck": 1}]), "itself"),
        (changed(collisions=[{"striking": 1, "struck": 7}]), "vehicle 7"),
        (changed(collisions=[{"striking": 1, "struck": 2, "x-speed": 3}]), "x-speed"),
        (changed(impacts=[{"object": "Tree"}]), r"field impacts\[0\].striking: is missing"),
        (changed(impacts=[{"striking": None}]), r"field impacts\[0\].striking: names no vehicle"),
        (changed(impacts=[{"striking": 7}]), "impacts"),
        (changed(impacts=[{"striking": 1, "object": "Cow"}]), r"field impacts\[0\].object: .*Animal"),
        (changed(impacts=[{"striking": 1, "roadside": "Front"}]), r"field impacts\[0\].roadside"),
        (changed(impacts={}), "impacts"),
        (changed(num_lanes=16**270), r"field num_lanes: \d{57}\.\.\. is no number"),
        (changed(vehicles=[changed()["vehicles"][1] | {"action": [[16**270, 0]]}]), r"action\[0\]: .* is no point"),
        (changed(road_type={date(2020, 1, 1): 1}), r"field road_type: \{datetime.*is none of"),
        (changed(**{"x-when": date(2020, 1, 1)}), 'field x-when: holds .*"2020-01-01"; write it in quotes'),
        (changed(**{"x-a\nb": 1}), r"field x-a\\nb: is none of .*; start fields of your own with x- and write"),
        (changed(**{"x-<a": 1}), "field x-<a: is none of"),
        (changed(env={"time": None, "weather": None, "x-a": {date(2020, 1, 1): 1}}), "field env.x-a: holds"),
    ],
)
def test_data_is_checked(content, complaint):
    with pytest.raises(InputError, match=complaint):
        parse_data(content, "case")


@pytest.mark.parametrize("form", [".json", ".yaml"])
def test_files_name_line_and_field(form):
    text = dump_crash_scenario(parse_crash_scenario(LISTING, ".txt", "listing"), form)
    line = 1 + text[: text.index("Nighttime")].count("\n")
    with pytest.raises(InputError, match=rf"case, line {line}: field env.time"):
        parse_crash_scenario(text.replace("Nighttime", "Teatime"), form, "case")


@pytest.mark.parametrize(
    ("form", "text", "complaint"),
    [
        (".json", '{"road_type": ', "line 1: broken JSON"),
        (".json", '{"a": 1, "a": 2}', "field a is there twice"),
        (".yaml", "a: [1", "broken YAML"),
        (".yaml", "a: 1\na: 2", "line 2: field a is there twice"),
        (".yaml", "", "not fields"),
    ],
)
def test_broken_files(form, text, complaint):
    with pytest.raises(InputError, match=complaint):
        parse_crash_scenario(text, form, "case")


def nested():
    content = [0] * 15_000
    for _ in range(50):
        content = {"x-" + "a" * 900: content}
    return content


@pytest.mark.parametrize("content", [nested(), {"." * 40_000: 1}], ids=["names in names", "a name of points"])
def test_long_names_take_little_memory(content):
    tracemalloc.start()
    with pytest.raises(InputError):
        parse_crash_scenario(json.dumps(content), ".json", "here")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 100_000_000  # 700 MB where the line of each value is kept under its whole name


def test_a_line_with_many_spaces_is_read_at_all():
    text = "<Scenario>: x" + " " * 400_000 + "x"  # looked at from each of its spaces it would outlast the tests
    with pytest.raises(InputError):
        parse_crash_scenario(text, ".txt", "here")
