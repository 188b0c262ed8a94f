"""Exported files are valid by the official schemas, and SUMO reads the roads back."""

import importlib.util
import math
import subprocess
from pathlib import Path

import pytest
from lxml import etree

from roadmend.core.errors import InputError
from roadmend.safe.construction import draw_scenario
from roadmend.safe.openscenario import export_scenario
from roadmend.world.families import sample_scenario
from roadmend.world.network import find_binary
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_actors import Brake, CutIn, Drift, Pedestrian, Trigger
from roadmend.world.scenario_networks import SumoConfiguration

from .crashes import ALL, HEAD_ON, crash, role, vehicle
from .lone import LONE, onlooker


def schema(package, path):
    folder = Path(next(iter(importlib.util.find_spec(package).submodule_search_locations)))
    return etree.XMLSchema(etree.parse(folder / path))


@pytest.fixture(scope="module")
def story_schema():
    return schema("schemas", "OpenSCENARIO_1_2.xsd")


@pytest.fixture(scope="module")
def road_schema():
    return schema("qc_opendrive", "schema/1.7.0/opendrive_17_core.xsd")


def drawn(name):
    return draw_scenario(role(ALL[name]), 0)


def drawn_with(word):
    return draw_scenario(role(crash("Straight", vehicle(), vehicle(manoeuvre=word))), 0)


def with_every_manoeuvre():
    scenario = sample_scenario("S5", 3)
    near, late = Trigger(ego_distance=20.0), Trigger(time=2.0)
    scripts = [[Brake(when=near)], *([CutIn(when=late, direction=way)] for way in ("left", "right", "ego"))]
    actors = [
        actor.model_copy(update={"manoeuvres": script}) for actor, script in zip(scenario.actors, scripts, strict=False)
    ]
    return scenario.model_copy(update={"actors": actors})


@pytest.mark.parametrize(
    "scenario",
    [
        *(pytest.param(drawn(name), id=name) for name in ("straight", "curve", "intersection", "tee", "merging")),
        *(pytest.param(drawn(name), id=name) for name in ("alone", "driveway", "parked", "lane change")),
        *(pytest.param(draw_scenario(onlooker(LONE[name]), 0), id=f"lone {name}") for name in ("trailer", "animal")),
        *(pytest.param(drawn_with(word), id=word) for word in ("U-turn", "Reverse")),
        pytest.param(with_every_manoeuvre(), id="manoeuvres"),
    ],
)
def test_both_files_are_valid_and_netconvert_reads_the_roads(scenario, tmp_path, story_schema, road_schema):
    story, roads = export_scenario(scenario, tmp_path)
    for file, grammar in ((story, story_schema), (roads, road_schema)):
        assert grammar.validate(etree.parse(file)), grammar.error_log
    back = tmp_path / "back.net.xml"
    subprocess.run(
        [find_binary("netconvert"), "--opendrive-files", roads, "--output-file", back, "--no-warnings"],
        check=True,
        capture_output=True,
    )
    assert etree.parse(back).findall("edge")
    assert sorted(path.name for path in tmp_path.glob("*")) == sorted([story.name, roads.name, back.name])


def test_the_story_says_what_the_scenario_does(tmp_path):
    scenario = draw_scenario(role(HEAD_ON), 0)
    story = etree.parse(export_scenario(scenario, tmp_path)[0])
    assert {each.get("name") for each in story.iter("ScenarioObject")} == {"ego", "v2"}
    (actor,) = scenario.actors
    (drift,) = (each for each in actor.manoeuvres if isinstance(each, Drift))
    target = next(story.iter("RelativeTargetLaneOffset"))
    assert (target.get("entityRef"), float(target.get("value"))) == ("v2", drift.offset)
    assert next(story.iter("LogicFile")).get("filepath") == f"{scenario.name}.xodr"
    speeds = [float(each.get("value")) for each in story.iter("AbsoluteTargetSpeed")]
    assert scenario.ego.speed in speeds
    assert float(next(story.iter("RoadCondition")).get("frictionScaleFactor")) == pytest.approx(1.0)


def test_a_second_drift_counts_from_where_the_first_one_led(tmp_path):
    scenario = draw_scenario(role(crash("Straight", vehicle(), vehicle(manoeuvre="Overtake"))), 0)
    (actor,) = scenario.actors
    offsets = [each.offset for each in actor.manoeuvres if isinstance(each, Drift)]
    assert len(offsets) == 2
    story = etree.parse(export_scenario(scenario, tmp_path)[0])
    targets = [*story.iter("RelativeTargetLaneOffset")]
    assert [(each.get("entityRef"), float(each.get("value"))) for each in targets] == [(actor.id, at) for at in offsets]
    assert not [*story.iter("AbsoluteTargetLaneOffset")]


@pytest.mark.parametrize(
    "scenario",
    [
        *(
            draw_scenario(role(crash("Intersection", vehicle(), vehicle("E2W", "Turn Left"))), index)
            for index in (0, 1)
        ),
        drawn_with("U-turn"),
        drawn_with("Reverse"),
        draw_scenario(onlooker(LONE["left"]), 0),
    ],
    ids=["turn 0", "turn 1", "U-turn", "Reverse", "lone"],
)
def test_a_line_of_ones_own_begins_where_the_vehicle_is(scenario, tmp_path):
    story = etree.parse(export_scenario(scenario, tmp_path)[0])
    (actor,) = scenario.actors
    entry = ".//AddEntityAction" if actor.depart else f".//Private[@entityRef='{actor.id}']"
    places = story.find(f"{entry}//WorldPosition"), story.find(".//Vertex//WorldPosition")
    (x, y), (first_x, first_y) = ([float(place.get(name)) for name in "xy"] for place in places)
    assert math.hypot(x - first_x, y - first_y) < 0.1
    last = [*story.iter("Vertex")][-1].find(".//WorldPosition")
    follow = actor.manoeuvres[-1]
    assert math.dist((float(last.get("x")), float(last.get("y"))), follow.points[-1]) < 0.3 * 5.0


def test_who_brakes_without_a_speed_of_its_own_goes_on_at_the_limit(tmp_path):
    scenario = draw_scenario(role(HEAD_ON), 0)
    script = [Brake(when=Trigger(time=2.0), speed=5.0)]
    actor = scenario.actors[0].model_copy(update={"speed": None, "manoeuvres": script})
    story = etree.parse(export_scenario(scenario.model_copy(update={"actors": [actor]}), tmp_path)[0])
    speeds = [float(each.get("value")) for each in story.iter("AbsoluteTargetSpeed")]
    assert speeds == [scenario.ego.speed, pytest.approx(35 * 0.44704, abs=0.01), 5.0, speeds[1]]


def test_what_stands_there_is_an_object_of_its_own(tmp_path):
    scenario = draw_scenario(onlooker(LONE["left"]), 0)
    story = etree.parse(export_scenario(scenario, tmp_path)[0])
    (thing,) = story.findall(".//MiscObject")
    assert thing.get("miscObjectCategory") == "pole"
    assert thing.find(".//Dimensions").get("length") == "0.3"
    place = story.find(".//Private[@entityRef='pole']//WorldPosition")
    assert float(place.get("x")) == scenario.obstacles[0].x


def test_the_same_scenario_gives_the_same_story(tmp_path):
    scenario = draw_scenario(role(HEAD_ON), 0)
    texts = [export_scenario(scenario, tmp_path / name)[0].read_bytes() for name in "ab"]
    assert texts[0] == texts[1]


def test_people_on_foot_and_foreign_traffic_are_refused(tmp_path):
    scenario = draw_scenario(role(HEAD_ON), 0)
    walker = Pedestrian(id="p", route=["forward"])
    with pytest.raises(InputError, match=r"actors\[0\]"):
        export_scenario(scenario.model_copy(update={"actors": [walker]}), tmp_path)
    with pytest.raises(InputError, match="its own traffic"):
        export_scenario(scenario.model_copy(update={"network": SumoConfiguration(path="x.sumocfg")}), tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda content: content["ego"].update(route=["forwards"]), r"ego\.route\[0\]"),
        (lambda content: content["ego"].update(route=[]), r"ego\.route"),
        (lambda content: content["ego"].update(lane=7), r"ego\.lane"),
        (lambda content: content["actors"][0].update(route=["backwards"]), r"actors\[0\]\.route\[0\]"),
        (lambda content: content["actors"][0].update(lane=7), r"actors\[0\]\.lane"),
    ],
)
def test_what_no_simulation_would_take_is_refused(change, words, tmp_path):
    content = draw_scenario(role(HEAD_ON), 0).model_dump()
    change(content)
    with pytest.raises(InputError, match=words):
        export_scenario(Scenario.model_validate(content), tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(("time", "begins"), [(3.0, 5.0), (7.0, 7.0)])
def test_who_enters_later_than_its_manoeuvre_is_due_begins_it_on_entry(time, begins, tmp_path):
    scenario = draw_scenario(role(HEAD_ON), 0)
    script = [Brake(when=Trigger(time=time))]
    late = scenario.actors[0].model_copy(update={"depart": 5.0, "manoeuvres": script})
    story = etree.parse(export_scenario(scenario.model_copy(update={"actors": [late]}), tmp_path)[0])
    times = story.findall(".//Event[@name='v2-1']//SimulationTimeCondition")
    assert [float(each.get("value")) for each in times] == [begins]


def test_a_folder_that_cannot_be_written_is_one_line(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="cannot be written"):
        export_scenario(draw_scenario(role(HEAD_ON), 0), tmp_path / "file")
