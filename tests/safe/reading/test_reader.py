"""The embedded reader against made-up summaries in many styles, and against rules of its parts."""

import re
from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from roadmend.core.resources import config_folder
from roadmend.safe.dsl import Action, Compass, DslModel, Manoeuvre, Position, RoadType, Side, Time, Weather
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.reading.reader import read_summary

PARAPHRASES = yaml.safe_load((Path(__file__).parent / "paraphrases.yaml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("case", PARAPHRASES, ids=[case["style"] for case in PARAPHRASES])
def test_paraphrases(case):
    data = dump_data(read_summary(case["summary"]).scenario)
    got = {
        "road": [data["road_type"], data["num_lanes"], data["stem_direction"]],
        "vehicles": [[v["model"], v["initial_position"], v["action"], v["speed_limit_mph"]] for v in data["vehicles"]],
        "env": [data["env"]["time"], data["env"]["weather"]],
    }

    def agree(want, value):
        return (
            all(map(agree, want, value)) and len(want) == len(value)
            if isinstance(want, list)
            else want in {"any", value}
        )

    for part, value in got.items():
        assert agree(case[part], value), (part, case[part], value)


@pytest.mark.parametrize("road_type", RoadType)
def test_the_sample_reports(road_type):
    folder = config_folder() / "reports" / road_type.value.lower()
    reading = read_summary((folder / "summary.txt").read_text(encoding="utf-8"))
    scenario = reading.scenario
    assert scenario.road.road_type is road_type
    assert None not in (scenario.road.lanes, scenario.environment.time, scenario.environment.weather)
    for vehicle in scenario.vehicles:
        assert None not in (vehicle.model, vehicle.initial_position, vehicle.action, vehicle.speed_limit_mph)
    assert len(scenario.collisions) == 1


def test_every_field_has_what_it_rests_on():
    summary = "V1, a 2010 Ford Focus, was northbound on a two-lane road. It was raining. V1 hit the rear of V2, a Jeep Wrangler."
    reading = read_summary(summary)
    for name, finding in reading.findings.items():
        assert finding.reason, name
        assert 0 < finding.confidence <= 1, name
        assert finding.sentence is None or finding.sentence in summary, name
    assert reading.findings["env.weather"].sentence == "It was raining."
    assert reading.findings["env.time"].value is None
    assert reading.findings["vehicles[0].speed_limit_mph"].reason == "no speed limit is mentioned"
    assert reading.scenario.vehicles[1].initial_position is Position.S2N  # hit from behind


def one(text):
    return read_summary(
        f"V1, a sedan, was traveling north on a two-lane road. V2, a van, was traveling south. {text}"
    ).scenario


@pytest.mark.parametrize(
    ("words", "time"),
    [
        ("It was dark but lighted.", Time.NIGHTTIME),
        ("The crash occurred at dawn.", Time.DAYTIME),
        ("It was dusk.", Time.DAYTIME),
        ("It was light outside.", Time.DAYTIME),
        ("It happened in the predawn hours.", Time.NIGHTTIME),
        ("It happened in the evening hours (daylight).", Time.DAYTIME),
        ("It happened in the late evening.", Time.NIGHTTIME),
        ("The time was 11:20 p.m.", Time.NIGHTTIME),
        ("It happened at 1430 hours.", Time.DAYTIME),
        ("V1 was dark blue.", None),
        ("V2 had daytime running lights.", None),
        ("Later that day the driver went to a hospital.", None),
    ],
)
def test_time(words, time):
    assert one(words).environment.time is time


@pytest.mark.parametrize(
    ("words", "weather"),
    [
        ("It was daylight and the sky was clear.", Weather.SUNNY),
        ("It was dark and the sky was clear.", Weather.CLEAR),
        ("It was cloudy and raining.", Weather.RAINY),
        ("There were no adverse weather conditions at night.", Weather.CLEAR),
        ("There was heavy fog.", Weather.FOGGY),
        ("Strong winds were blowing.", Weather.WINDY),
        ("It was sleeting.", Weather.SNOWY),
        ("It was not raining.", None),
        ("The road was wet.", None),
        ("V2 waited for traffic to clear.", None),
        ("They were on a windy road.", None),
        ("There was a snow storm.", Weather.SNOWY),
        ("It was daytime and clear.", Weather.SUNNY),
        ("It was late night and clear.", Weather.CLEAR),
        ("V1 had its fog lights on.", None),
    ],
)
def test_weather(words, weather):
    assert one(words).environment.weather is weather


@pytest.mark.parametrize(
    ("words", "limit"),
    [
        ("The posted speed limit was 35 mph.", 35),
        ("The speed limit was thirty-five miles per hour.", 35),
        ("The speed limit was 72 km/h.", 45),
        ("The posted speed limit was 89KMPH (55MPH).", 55),
        ("V1 was traveling at approximately 60 mph.", None),
        ("The posted speed was 40 mph.", 40),
        ("V1 was traveling along a road with a 25 mph limit.", 25),
        ("The speed limit on V1's road was 30 mph and the speed limit on V2's road was 50 mph.", 30),
        ("The speed limit was 55 mph with an advisory speed of 35 mph.", 55),
        ("An advisory speed of 25 mph is posted with a speed limit sign.", None),
        ("They met at an intersection. The speed limit of the east/west road is 30 mph.", None),
    ],
)
def test_speed_limit(words, limit):
    assert one(words).vehicles[0].speed_limit_mph == limit


@pytest.mark.parametrize(
    ("words", "action", "manoeuvre"),
    [
        ("V1 turned left into a lot.", Action.TURN_LEFT, Manoeuvre.TURN_LEFT),
        ("V1 was making a right-hand turn.", Action.TURN_RIGHT, Manoeuvre.TURN_RIGHT),
        ("The driver of V1 turned the steering wheel to the left.", Action.MOVE_FORWARD, Manoeuvre.MOVE_FORWARD),
        ("V1 stopped for a vehicle ahead that was turning left.", Action.MOVE_FORWARD, None),
        ("V1 crossed the centerline into the southbound lane.", Action.MOVE_FORWARD, Manoeuvre.ENTER_THE_WRONG_WAY),
        ("V1 changed lanes.", Action.MOVE_FORWARD, Manoeuvre.CHANGING_LANE),
        ("V1 was stopped at the curb.", Action.MOVE_FORWARD, Manoeuvre.STOP),
        ("After the impact V1 turned left.", Action.MOVE_FORWARD, None),
    ],
)
def test_actions(words, action, manoeuvre):
    vehicle = one(words).vehicles[0]
    assert vehicle.action is action
    assert manoeuvre is None or vehicle.manoeuvre is manoeuvre


@pytest.mark.parametrize(
    ("words", "collision"),
    [
        ("The front of V1 struck the left side of V2.", (1, 2, Side.FRONT, Side.LEFT)),
        ("The right side of V1 was struck by the front of V2.", (2, 1, Side.FRONT, Side.RIGHT)),
        ("V1's front impacted V2's rear.", (1, 2, Side.FRONT, Side.REAR)),
        ("V2 impacted the rear of V1 with its front.", (2, 1, Side.FRONT, Side.REAR)),
        ("V1 and V2 collided head-on.", (1, 2, Side.FRONT, Side.FRONT)),
        ("V2 drifted over, striking the left side of V1 with the front of V2.", (2, 1, Side.FRONT, Side.LEFT)),
        ("V1 rear-ended V2.", (1, 2, Side.FRONT, Side.REAR)),
    ],
)
def test_collisions(words, collision):
    (found,) = one(words).collisions
    assert (found.striking, found.struck, found.striking_side, found.struck_side) == collision


CROSSING = "They met at a four-way intersection. V1, a sedan, was traveling north."


@pytest.mark.parametrize(
    ("words", "position"),
    [
        ("The front of V2, a van, struck the right side of V1.", Position.E2W),
        ("The front of V2, a van, struck the left side of V1.", Position.W2E),
        ("The front of V1 struck the right side of V2, a van.", Position.W2E),
        ("The front of V1 struck the left side of V2, a van.", Position.E2W),
        ("V1 turned left. The front of V2, a van, struck the right side of V1.", Position.N2S),
        ("V1 turned left. Its front was struck by the front of V2, a van.", Position.N2S),
        ("V1 turned right. The front of his car struck the right front of V2, a van.", Position.W2E),
        ("V2, a van, turned right. The front of V1 struck the front of V2.", Position.E2W),
        ("V2, a van, turned left in front of V1. The front of V1 struck the right side of V2.", Position.N2S),
        ("The rear of V2, a van, struck the left side of V1.", None),
        ("V2, a van, turned right. The front of V1 struck the right side of V2.", None),
    ],
)
def test_where_the_other_came_from_follows_from_the_sides_that_met(words, position):
    assert read_summary(f"{CROSSING} {words}").scenario.vehicles[1].initial_position is position


def test_away_from_a_junction_the_sides_that_met_say_nothing():
    summary = "V1, a sedan, was traveling north on a straight road. The front of V2, a van, struck the left side of V1."
    assert read_summary(summary).scenario.vehicles[1].initial_position is None


@pytest.mark.parametrize(
    ("where", "position"),
    [
        ("on a two-way street and hit V2, a van parked on the right shoulder", Position.W2E),
        ("on a two-way street and hit V2, a van parked at the left road edge", Position.E2W),
        ("on a two-way street and hit V2, a van parked along the north curb", Position.E2W),
        ("on a two-way street and hit V2, a van parked along the south side", Position.W2E),
        ("on a two-way street and hit V2, a van parked along the east side of a lot", None),
        ("on a two-way street and hit V2, a van parked nearby", None),
        ("on a one-way street and hit V2, a van parked at the left road edge", Position.W2E),
        ("the wrong way on a one-way street and hit V2, a van that was parked", None),
    ],
)
def test_a_parked_vehicle_faces_as_traffic_on_its_side_does(where, position):
    summary = f"V1, a sedan, was traveling east {where}."
    assert read_summary(summary).scenario.vehicles[1].initial_position is position


def test_parked_beside_nobody_who_travels_along():
    assert (
        read_summary("V1, a sedan, hit V2, a van parked at the left curb.").scenario.vehicles[1].initial_position
        is None
    )


def test_who_turns_left_in_front_of_another_does_not_go_its_way():
    assert one_heading("V2, a van, turned left in front of V1.") is None
    assert one_heading("V2, a van, was in front of V1.") is Position.S2N


def one_heading(words):
    return (
        read_summary(f"V1, a sedan, was northbound on a two-lane road. {words}").scenario.vehicles[1].initial_position
    )


def test_a_bend_that_leads_to_the_place_makes_the_road_a_curve():
    summary = "V1, a sedan, hit V2, a van, on a road that curved to the left just before the crash site."
    assert read_summary(summary).scenario.road.road_type is RoadType.CURVE


def test_a_road_that_ends_at_a_route_makes_a_t_intersection():
    summary = "V1, a sedan, hit V2, a van, at the junction of a side road that ends at the state route."
    assert read_summary(summary).scenario.road.road_type is RoadType.T_INTERSECTION


@pytest.mark.parametrize(
    ("road", "lanes"),
    [
        ("The street is two lanes.", 2),
        ("The road has four lanes in both directions with dedicated left turn lanes.", 4),
        ("The road has two lanes in each direction and a center turn lane.", 5),
    ],
)
def test_lanes(road, lanes):
    assert read_summary(f"V1, a sedan, hit V2, a van. {road}").scenario.road.lanes == lanes


def test_the_only_limit_holds_for_the_road_that_joins_too():
    summary = (
        "At an intersection a side street meets a two-lane, north/south highway. The posted speed limit was 45 mph. "
        "V1, a sedan, was traveling west. V2, a van, was traveling south. V2 hit V1."
    )
    assert [vehicle.speed_limit_mph for vehicle in read_summary(summary).scenario.vehicles] == [45, 45]


def test_who_is_numbered_by_nothing_but_the_case_vehicle():
    summary = (
        "The case vehicle is a 2015 Honda Fit that was struck by a 2012 Jeep Patriot on a two-lane road. The case vehicle "
        "was traveling north. The Jeep was traveling south."
    )
    vehicles = read_summary(summary).scenario.vehicles
    assert [vehicle.model for vehicle in vehicles] == ["Sedan", "SUV"]
    assert [vehicle.initial_position for vehicle in vehicles] == [Position.S2N, Position.N2S]


def test_two_of_one_make_stay_two():
    summary = "A 2010 Honda Civic was traveling north. A 2012 Honda Pilot hit the Civic. The Honda Pilot was new."
    assert [vehicle.model for vehicle in read_summary(summary).scenario.vehicles] == ["Sedan", "SUV"]


def test_a_pair_with_one_verb_goes_one_way():
    summary = "V1, a 2010 Ford Focus, and V2, a 2012 Jeep Patriot, were westbound on a two-lane road. V1 hit V2."
    assert {vehicle.initial_position for vehicle in read_summary(summary).scenario.vehicles} == {Position.E2W}


def test_what_follows_that_is_said_of_the_vehicle_before():
    summary = (
        "V1 was a 2010 Ford Focus that was going north on a two-lane road. V2 was a Jeep Patriot that was going west."
    )
    headings = [vehicle.initial_position for vehicle in read_summary(summary).scenario.vehicles]
    assert headings == [Position.S2N, Position.E2W]


def test_who_turns_from_a_lane_came_along_it():
    summary = (
        "At a T-intersection a two-lane road that leads south meets a highway. V1, a Mazda6, turned right from the "
        "northbound lane onto the eastbound lane. V2, a van, was eastbound and struck the rear of V1."
    )
    scenario = read_summary(summary).scenario
    assert scenario.road.stem is Compass.SOUTH
    assert scenario.vehicles[0].model is DslModel.SEDAN
    assert scenario.vehicles[0].initial_position is Position.S2N


def test_the_lanes_of_the_crash_give_the_heading_of_who_has_none():
    summary = "This crash took place on a northbound interstate. V1, a sedan in lane one, hit V2, a van in lane two."
    assert {vehicle.initial_position for vehicle in read_summary(summary).scenario.vehicles} == {Position.S2N}


def test_what_is_parked_has_a_body_too():
    summary = "V1, a sedan, was northbound on a two-lane road and hit a parked 2003 Ford Econoline."
    assert [vehicle.model for vehicle in read_summary(summary).scenario.vehicles] == ["Sedan", "Minivan"]


def test_lanes_that_are_not_called_lanes_again():
    summary = "V1, a sedan, hit V2, a van, on the southbound lanes of a highway. The three southbound are straight."
    assert read_summary(summary).scenario.road.lanes == 3


def test_who_touched_nothing_is_left_out():
    reading = read_summary(
        "V1, a sedan, hit V2, a van. V3 (non-contact vehicle), a bus, was ahead of V1. They were on a two-lane road."
    )
    assert len(reading.scenario.vehicles) == 2
    assert reading.left_out == (3,)


@pytest.mark.parametrize("summary", ["", "   ", "No one was there.", "12345 !!! ???"])
def test_no_vehicle(summary):
    assert read_summary(summary) is None


@pytest.mark.parametrize(
    "word", ["v1 ", "(", "a the ", "vehicle 1, ", "north ", "lane in ", "turned left ", "struck the "]
)
def test_long_nonsense_takes_bounded_time(word):
    read_summary(word * (60_000 // len(word)))  # pytest's time-out is the assertion


PIECES = [
    "V1",
    "V2",
    "V3",
    "V9",
    "a",
    "sedan,",
    "(V2)",
    "was",
    "the",
    "driver",
    "of",
    "were",
    "both",
    "vehicles",
    "traveling",
    "heading",
    "stopped",
    "parked",
    "north",
    "southbound",
    "east",
    "west/east",
    "in",
    "lane",
    "of",
    "on-ramp",
    "ramp",
    "merged",
    "intersection",
    "T-intersection",
    "curve",
    "struck",
    "hit",
    "the",
    "front",
    "rear",
    "left",
    "side",
    "by",
    "with",
    "its",
    "turned",
    "left",
    "two-lane",
    "four",
    "lanes",
    "in",
    "each",
    "direction",
    "speed",
    "limit",
    "35",
    "mph",
    "0",
    "300",
    "km/h",
    "for",
    "and",
    "while",
    "which",
    "that",
    "it",
    "he",
    ".",
    ".",
    ".",
    ",",
    ";",
    "(",
    ")",
    "dark",
    "daylight",
    "raining",
    "clear",
    "2003",
    "Ford",
    "F-150",
    "Mazda",
    "3",
    "pickup",
    "and",
    "V2",
    "came",
    "to",
    "rest",
    "facing",
    "stop",
    "sign",
    "one-way",
    "24",
    "Vehicle",
    "Vehicle",
    "1",
    "#2",
]


@given(st.lists(st.sampled_from(PIECES), max_size=60))
@settings(max_examples=150, deadline=None)
def test_whatever_the_words_the_result_is_a_scenario_or_nothing(pieces):
    reading = read_summary(" ".join(pieces))
    if reading is not None:
        data = dump_data(reading.scenario)
        assert parse_data(data, "here") == reading.scenario
        assert data["road_type"] == reading.findings["road_type"].value
        assert len(data["vehicles"]) == sum(name.endswith(".model") for name in reading.findings)


TURNED = {"north": "east", "east": "south", "south": "west", "west": "north"}
TURNED_POSITION = {"S2N": "W2E", "W2E": "N2S", "N2S": "E2W", "E2W": "S2N"}


def facts(summary):
    data = dump_data(read_summary(summary).scenario)
    for vehicle in data["vehicles"]:
        del vehicle["manoeuvre"]  # its words are fewer than those of the rest
    return data


@pytest.mark.parametrize("case", PARAPHRASES, ids=[case["style"] for case in PARAPHRASES])
def test_a_turned_world_gives_a_turned_scenario(case):
    if re.search(r"/B|\b[NSEW]B\b", case["summary"]):
        pytest.skip("has its directions as single letters")

    def turn(match):
        word = TURNED[match[0].lower()]
        return word.capitalize() if match[0][0].isupper() else word

    want = facts(case["summary"])
    for vehicle in want["vehicles"]:
        vehicle["initial_position"] = TURNED_POSITION.get(vehicle["initial_position"], vehicle["initial_position"])
    if want["stem_direction"]:
        want["stem_direction"] = TURNED[want["stem_direction"].lower()].capitalize()
    assert facts(re.sub("north|south|east|west", turn, case["summary"], flags=re.IGNORECASE)) == want


@pytest.mark.parametrize(
    ("pattern", "put"),
    [
        (r"\b(?:V|Vehicle (?:no\. )?)([123])\b", r"Unit #\1"),
        (r"\bwas traveling (north|south|east|west)\b", r"was proceeding in a \1erly direction"),
        (r"\bwas traveling (north|south|east|west)(?:bound)?\b", r"was \1bound"),
        (r"\bstruck\b", "collided with"),
        (r"\broad(?:way)?\b", "highway"),
        (r"It was daylight", "It happened in daylight hours"),
        (r"(?i)the sky was (\w+)", r"there were \1 skies"),
        (r"\d+ ?k\w*/?h\w* \((\d+) ?mph\)", r"\1 MPH"),
        (r"^.*$", lambda match: match[0].upper()),
    ],
    ids=["unit", "direction", "bound", "collided", "highway", "daylight", "skies", "mph alone", "capitals"],
)
def test_other_words_for_the_same_change_nothing(pattern, put):
    changed = 0
    for road_type in RoadType:
        summary = (config_folder() / "reports" / road_type.value.lower() / "summary.txt").read_text(encoding="utf-8")
        other = re.sub(pattern, put, summary, flags=re.MULTILINE)
        changed += other != summary
        assert facts(other) == facts(summary)
    assert changed > 0
