"""What the reader makes of contradictions, gaps, second sources and slips of the pen."""

import pytest

from roadmend.safe.claims import Box, Claim, ClaimSource, ContactClaim, DirectionClaim, Span, WayRelation
from roadmend.safe.dsl import Action, Compass, Control, DslModel, Manoeuvre, Position, RoadType, Side, Time, Weather
from roadmend.safe.reading.reader import assemble, read_claims, read_summary

PAIR = "V1, a 2012 Honda Civic, was traveling north on a two-lane road. V2, a 2001 Ford F-150, was traveling south."


def read(text):
    return read_summary(text).scenario


def findings(text):
    return read_summary(text).findings


@pytest.mark.parametrize(
    ("words", "value"),
    [
        ("It was raining.", Weather.RAINY),
        ("Snow was falling heavily.", Weather.SNOWY),
        ("It had rained earlier, but the sky was clear. It was noon.", Weather.SUNNY),
        ("It was dark and the sky was clear.", Weather.CLEAR),
        ("The windshield was cleared and the way was clear.", None),
        ("", None),
    ],
)
def test_weather(words, value):
    assert read(f"{PAIR} {words}").environment.weather is value


@pytest.mark.parametrize(
    ("words", "value"),
    [
        ("at dawn", Time.DAYTIME),
        ("after dark", Time.NIGHTTIME),
        ("at 2:30 p.m.", Time.DAYTIME),
        ("at 0215 hours", Time.NIGHTTIME),
        ("at about 23:40", Time.NIGHTTIME),
        ("on a Tuesday", None),
        ("and V1 came to rest 21.34 meters on", None),
        ("and V2 slid for 12.50 m", None),
    ],
)
def test_time(words, value):
    assert read(f"{PAIR} The crash happened {words}.").environment.time is value


@pytest.mark.parametrize(
    ("words", "mph"),
    [
        ("The posted speed limit was 45 mph.", 45),
        ("The speed limit is 72 km/h (45 mph).", 45),
        ("The limit there is 80 km/h.", 50),
        ("V1 was traveling at 60 mph.", None),
        ("An advisory speed of 25 mph was posted. ", None),
        ("psl 35", 35),
    ],
)
def test_limits(words, mph):
    assert [vehicle.speed_limit_mph for vehicle in read(f"{PAIR} {words}").vehicles] == [mph, mph]


@pytest.mark.parametrize(
    ("words", "lanes"),
    [
        ("The road had two lanes in each direction.", 4),
        ("It was a six-lane divided highway.", 6),
        ("There were three northbound lanes and two southbound lanes.", 5),
        ("One lane runs each way, with a center turn lane.", 3),
        ("The roadway consists of one northbound lane and one southbound lane.", 2),
        ("It has three lanes on this side and the other side has two.", 5),
        ("Two lanes run north and two south.", 4),
        ("There are two lanes going my way (and three against me).", 5),
        ("It is 1 lane wide.", 1),
        ("The carriageways, each with two lanes, are apart.", 4),
        ("It is a six-lane divided highway (three northbound lanes, a median, and three southbound lanes).", 6),
        ("It has one northbound left-turn lane, two northbound through lanes and one southbound lane.", 4),
    ],
)
def test_lanes(words, lanes):
    text = "V1, a van, was traveling north and struck the rear of V2, a car that was also traveling north."
    assert read(f"{text} {words}").road.lanes == lanes


@pytest.mark.parametrize(
    ("words", "model"),
    [
        ("a 2009 Saab 9-5", DslModel.SEDAN),
        ("a Chevy Tahoe", DslModel.SUV),
        ("a Dodge Grand Caravan", DslModel.MINIVAN),
        ("a Toyota Tacoma", DslModel.PICKUP),
        ("a Dodge Ram conversion van", DslModel.MINIVAN),
        ("an 18-wheeler", DslModel.SEMI_TRUCK),
        ("a Scania lorry", DslModel.SEMI_TRUCK),
        ("a four-door saloon", DslModel.SEDAN),
        ("a vehicle of unknown make", None),
        ("a motorcycle", None),
    ],
)
def test_models(words, model):
    assert read(f"V1 was {words}. V1 was traveling east at night and hit a tree.").vehicles[0].model is model


@pytest.mark.parametrize(
    ("words", "action", "manoeuvre"),
    [
        ("V1 turned left", Action.TURN_LEFT, Manoeuvre.TURN_LEFT),
        ("V1 was making a right turn", Action.TURN_RIGHT, Manoeuvre.TURN_RIGHT),
        ("V1 made a U-turn", Action.TURN_LEFT, Manoeuvre.U_TURN),
        ("V1 was parked", Action.MOVE_FORWARD, Manoeuvre.PARKED),
        ("V1 was backing up", Action.MOVE_FORWARD, Manoeuvre.REVERSE),
        ("V1 was stopped at the light", Action.MOVE_FORWARD, Manoeuvre.STOP),
        ("V1 changed lanes to the left", Action.MOVE_FORWARD, Manoeuvre.CHANGING_LANE),
        ("V1 drifted across the center line", Action.MOVE_FORWARD, Manoeuvre.ENTER_THE_WRONG_WAY),
        ("The driver of V1 turned the wheel to the left", Action.MOVE_FORWARD, Manoeuvre.MOVE_FORWARD),
    ],
)
def test_manoeuvres(words, action, manoeuvre):
    vehicle = read(f"V1, a sedan, was northbound. V2, a van, was southbound. {words} and was hit by V2.").vehicles[0]
    assert (vehicle.action, vehicle.manoeuvre) == (action, manoeuvre)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("V1 struck V2 in the rear.", (1, 2, Side.FRONT, Side.REAR)),
        ("V2 was rear-ended by V1.", (1, 2, Side.FRONT, Side.REAR)),
        ("The front of V2 hit the left side of V1.", (2, 1, Side.FRONT, Side.LEFT)),
        ("V1 was T-boned by V2 on the passenger side.", (2, 1, Side.FRONT, Side.RIGHT)),
        ("V1 and V2 collided head-on.", (1, 2, Side.FRONT, Side.FRONT)),
        ("V1 could not avoid striking V2 with its front.", (1, 2, Side.FRONT, None)),
    ],
)
def test_contacts(words, expected):
    collision = read(f"V1, a sedan, was traveling north. V2, a van, was also on the road. {words}").collisions[0]
    assert (collision.striking, collision.struck, collision.striking_side, collision.struck_side) == expected


def test_what_was_avoided_is_no_contact():
    text = f"{PAIR} V1 swerved to avoid hitting V2, and V1 hit a tree."
    assert read(text).collisions == ()


def test_a_direction_follows_from_the_contact():
    text = "V1, a sedan, was traveling west on a straight road and ran into the back of V2, a van that had stopped."
    assert read(text).vehicles[1].initial_position is Position.E2W


def test_the_stem_follows_from_the_ways():
    text = (
        "V1, a sedan, was eastbound and turned left at the T-intersection. V2, a van, was southbound going straight. "
        "The front of V2 struck the left side of V1."
    )
    assert read(text).road.stem is Compass.WEST


def test_a_contradiction_is_told():
    text = (
        "V1, a sedan, was traveling south when it struck the rear of V2, a van. V2 had been stopped in the northbound lane. "
        "The road has two lanes."
    )
    finding = findings(text)["vehicles[1].initial_position"]
    assert finding.confidence < 0.9
    assert finding.against or finding.second


def test_two_vehicles_on_one_spot_from_two_sides_are_in_doubt():
    text = "V1, a sedan, was northbound. V1 was southbound. V2, a van, was eastbound and hit V1 at the intersection."
    finding = findings(text)["vehicles[0].initial_position"]
    assert finding.value is None or finding.confidence < 0.8


def test_what_is_not_said_is_open():
    scenario = read("A sedan and a pickup collided.")
    assert scenario.road.lanes is None
    assert [vehicle.initial_position for vehicle in scenario.vehicles] == [None, None]
    assert [vehicle.speed_limit_mph for vehicle in scenario.vehicles] == [None, None]
    assert (scenario.environment.time, scenario.environment.weather) == (None, None)


def test_slips_of_the_pen():
    text = (
        "v1 a 2010 toyota camry was travling northbound on a two lane road. v2 a ford explorer was going soutbound. v1 croossed "
        "the centerline and strcuk v2 hed on. it was rainning at nght"
    )
    scenario = read(text)
    assert [vehicle.initial_position for vehicle in scenario.vehicles] == [Position.S2N, Position.N2S]
    assert [vehicle.model for vehicle in scenario.vehicles] == [DslModel.SEDAN, DslModel.SUV]
    assert scenario.environment.weather is Weather.RAINY


def test_signs_medians_and_bends():
    road = read(f"{PAIR} The divided highway curves to the left and is controlled by a traffic signal.").road
    assert (road.is_divided, road.control) == (True, Control.SIGNAL)
    curve = read(
        "V1, a sedan, was traveling north on an undivided road, entered a curve to the right and hit a tree."
    ).road
    assert (curve.road_type, curve.bend, curve.is_divided) == (RoadType.CURVE, Side.RIGHT, False)


def test_every_phrase_is_found_again():
    text = f"{PAIR} It was dark and foggy. The posted speed limit was 45 mph."
    for name, finding in findings(text).items():
        for claim in finding.claims[:1]:
            assert isinstance(claim.where, Span), name
            assert text[claim.where.start : claim.where.end]
    fog = findings(text)["env.weather"].claims[0].where
    assert text[fog.start : fog.end] == "foggy"


def test_vehicles_that_touched_nothing_are_left_out():
    text = (
        "A Ford Focus was heading east. A Honda Civic ahead of it had stopped because a truck in front was waiting to turn. "
        "The Focus hit the rear of the Civic."
    )
    assert len(read(text).vehicles) == 2


def test_a_second_source_fills_a_gap():
    said = read_claims("V1, a sedan, was northbound and struck the left side of V2, a van, at an intersection.")
    box = Box(10, 10, 40, 20)
    more = [Claim("vehicles[1].initial_position", Position.W2E, 0.95, ClaimSource.SKETCH, "its arrow", box)]
    alone, both = assemble(said), assemble(said, more)
    assert both.scenario.vehicles[1].initial_position is Position.W2E
    finding = both.findings["vehicles[1].initial_position"]
    assert finding.confidence > alone.findings["vehicles[1].initial_position"].confidence - 0.5
    assert finding.claims[0].where == box


def test_a_second_source_that_contradicts_lowers_the_confidence():
    said = read_claims(PAIR)
    more = [Claim("vehicles[0].initial_position", Position.E2W, 0.9, ClaimSource.SKETCH, "its arrow", None)]
    path = "vehicles[0].initial_position"
    assert assemble(said, more).findings[path].confidence < assemble(said).findings[path].confidence
    assert assemble(said, more).findings[path].against


def test_relations_and_contacts_of_a_second_source():
    said = read_claims("V1, a sedan, was traveling north and hit V2, a van.")
    more = [
        DirectionClaim(0, 1, WayRelation.OPPOSITE, 0.9, ClaimSource.SKETCH, "they face each other"),
        ContactClaim(0, 1, Side.FRONT, Side.FRONT, 0, 0.9, ClaimSource.SKETCH, "their fronts touch"),
    ]
    assert assemble(said, more).scenario.vehicles[1].initial_position is Position.N2S


def test_the_cast_is_named_for_the_sketch():
    cast = read_claims(PAIR).cast
    assert [member.number for member in cast] == [1, 2]
    assert "honda civic" in cast[0].names
    assert cast[1].model is DslModel.PICKUP


@pytest.mark.parametrize("confidence", [0.0, 1.1])
def test_a_confidence_out_of_bounds(confidence):
    with pytest.raises(ValueError, match="confidence"):
        Claim("road_type", RoadType.CURVE, confidence, ClaimSource.SKETCH, "")


def test_places_in_the_cast_and_boxes():
    with pytest.raises(ValueError, match="no two places"):
        DirectionClaim(1, 1, WayRelation.SAME, 0.5, ClaimSource.SKETCH, "")
    with pytest.raises(ValueError, match="before"):
        Box(2, 0, 1, 1)
    with pytest.raises(ValueError, match="span"):
        Span(3, 2)


def test_what_investigators_code_is_not_told():
    codes = "The critical precrash event for V1 was coded as other vehicle stopped in the southbound lane."
    scenario = read(f"{codes} {PAIR} The speed limit for V2 was 45 mph.")
    assert [vehicle.initial_position for vehicle in scenario.vehicles] == [Position.S2N, Position.N2S]
    assert [vehicle.speed_limit_mph for vehicle in scenario.vehicles] == [None, 45]


@pytest.mark.parametrize("text", ["", ".", "V", "1 1 1", "the the the", "\n\n\n"])
def test_what_says_nothing(text):
    assert read_summary(text) is None


def test_many_vehicles_are_read_in_one_go():
    numbers = range(1, 10)
    text = " ".join(f"V{number}, a sedan, was northbound and hit V{number % 9 + 1} in the rear." for number in numbers)
    assert [vehicle.initial_position for vehicle in read(text).vehicles] == [Position.S2N] * 9


def test_she_and_he_are_told_apart():
    text = (
        "A woman was driving a Honda Civic north. A man was driving a Ford F-150 behind her. He was looking at his "
        "phone and struck her car in the rear."
    )
    scenario = read(text)
    assert [vehicle.initial_position for vehicle in scenario.vehicles] == [Position.S2N, Position.S2N]
    assert (scenario.collisions[0].striking, scenario.collisions[0].struck) == (2, 1)


@pytest.mark.parametrize(
    ("text", "mph"),
    [
        ("They let you go 55.", 55),
        ("Fifty is what the signs say on that road.", 50),
        ("It is a thirty-five zone.", 35),
        ("They raised it to 45 last year.", 45),
        ("The road is restricted to 80 km/h.", 50),
        ("Everybody was going seventy, which is what is allowed.", 70),
        ("The car was doing 60 there.", None),
        ("The wind was gusting to 50.", None),
    ],
)
def test_limits_in_other_words(text, mph):
    scenario = read(f"{PAIR} {text}")
    assert [vehicle.speed_limit_mph for vehicle in scenario.vehicles] == [mph, mph]


@pytest.mark.parametrize(
    ("text", "lanes"),
    [
        ("The road has two lanes up and two down.", 4),
        ("It has one lane each way and a middle turning lane.", 3),
        ("It is a dual two-lane road.", 4),
        ("The street has four lanes in all.", 4),
        ("It is a six-laner.", 6),
        ("There are three lanes that way and three the other way.", 6),
    ],
)
def test_lanes_in_other_words(text, lanes):
    assert read(f"{PAIR} {text}").road.lanes == lanes


def test_numbers_of_units_are_no_lanes():
    assert read("U1 WB on wet rd crossed the line and hit U2 EB. U1 l side to U2 front. 2 ln.").road.lanes == 2


@pytest.mark.parametrize(
    ("text", "model"),
    [
        ("There was no other car. I was driving my pickup north and hit a pole.", [DslModel.PICKUP]),
        ("A van was going north, swerved to miss a dog and a taxi, and hit a tree.", [DslModel.MINIVAN]),
    ],
)
def test_vehicles_that_were_not_there_or_were_missed(text, model):
    assert [vehicle.model for vehicle in read(text).vehicles] == model


def test_the_weather_of_another_day():
    text = f"{PAIR} It was fine and dry. It rained heavily the following day."
    assert read(text).environment.weather is read(f"{PAIR} It was fine and dry.").environment.weather
