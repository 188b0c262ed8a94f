"""Answers held against witnesses: what is believed, what is objected to, what is kept, and how that is told."""

from dataclasses import replace

import pytest

from roadmend.language.chat import Image
from roadmend.safe.answer_check import ANSWER, GEOMETRY, META, READER, TEXT, AnswerCheck, FieldCheck, unchecked
from roadmend.safe.dsl import Position, RoadType
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.encoder import MetaMessage
from roadmend.safe.extraction import Extraction, FieldEvidence, Witness
from roadmend.safe.reading_alignment import flat
from roadmend.safe.report import CrashReport
from roadmend.safe.settlement import settle

SUMMARY = "V1 was traveling west, V2 north; the limit is 40 mph. V1 hit the right side of V2 in the sun."
TRUTH = parse_data(
    {
        "road_type": "Intersection",
        "num_lanes": 4,
        "stem_direction": None,
        "vehicles": [
            {"model": "Sedan", "initial_position": "E2W", "action": "Move Forward", "speed_limit_mph": 40},
            {"model": "Pickup", "initial_position": "S2N", "action": "Move Forward", "speed_limit_mph": 40},
        ],
        "env": {"time": "Daytime", "weather": "Sunny"},
        "collisions": [{"striking": 1, "struck": 2, "striking_side": "Front", "struck_side": "Right"}],
    },
    "truth",
)
META_MESSAGE = MetaMessage(RoadType.INTERSECTION, (Position.E2W, Position.S2N))


def reading(scenario=TRUTH, confidence=0.9, **others):
    evidence = {
        name: FieldEvidence(value, f"Sentence of {name}.", others.get(name, confidence), "a rule")
        for name, value in flat(scenario).items()
    }
    return Extraction(scenario, evidence, "there is none")


def changed(**fields):
    data = dump_data(TRUTH)
    for field, value in fields.items():
        *path, last = field.split("__")
        place = data
        for part in path:
            place = place[int(part) if part.isdigit() else part]
        place[last] = value
    return parse_data(data, "changed")


def check(scenario, read=None, meta=META_MESSAGE, summary=SUMMARY, sketch=None):
    checks = AnswerCheck(CrashReport("case", summary, sketch), read).of_scenario(scenario, meta)
    return {each.field: each for each in checks}


def settled_with(scenario, read, meta=META_MESSAGE, summary=SUMMARY):
    return settle(scenario, [*check(scenario, read, meta, summary).values()], read, summary)


def objections(checks):
    return {name: told for name, each in checks.items() if (told := each.objection()) is not None}


def test_a_right_answer_meets_no_objection():
    checks = check(TRUTH, reading())
    assert objections(checks) == {}
    settled, evidence = settle(TRUTH, [*checks.values()], reading(), SUMMARY)
    assert settled == TRUTH
    assert not any(each.disputed for each in evidence.values())
    assert evidence["num_lanes"].confidence > 0.95
    assert evidence["num_lanes"].sentence == "Sentence of num_lanes."
    assert evidence["num_lanes"].reason == "the model's answer, as the embedded reader has it"
    assert "vehicles" not in evidence


def test_an_answer_that_nobody_else_speaks_of_is_alone():
    checks = check(TRUTH, None, meta=None)
    _, evidence = settle(TRUTH, [*checks.values()], None, SUMMARY)
    assert evidence["num_lanes"] == FieldEvidence(4, None, 0.8, "the model's answer alone, see the exchanges")
    assert next(iter(unchecked(TRUTH))).said[0].source == ANSWER


FALSE = [
    ("road_type", {"road_type": "Straight"}),
    ("num_lanes", {"num_lanes": 2}),
    ("vehicles[0].model", {"vehicles__0__model": "SUV"}),
    ("vehicles[1].initial_position", {"vehicles__1__initial_position": "N2S"}),
    ("vehicles[1].action", {"vehicles__1__action": "Turn Right"}),
    ("vehicles[0].speed_limit_mph", {"vehicles__0__speed_limit_mph": 25}),
    ("env.time", {"env__time": "Nighttime", "env__weather": "Clear"}),
    ("env.weather", {"env__weather": "Rainy"}),
    ("env.weather", {"env__weather": None}),
    ("collisions", {"collisions": []}),
    ("collisions[0].striking_side", {"collisions__0__striking_side": "Left"}),
    ("collisions[0].struck_side", {"collisions__0__struck_side": None}),
]


@pytest.mark.parametrize(("field", "change"), FALSE)
def test_a_false_field_is_told_and_the_reader_that_is_surer_is_kept_to(field, change):
    false = changed(**change)
    checks = check(false, reading())
    assert field in objections(checks)
    settled, evidence = settle(false, [*checks.values()], reading(), SUMMARY)
    assert flat(settled)[field] == flat(TRUTH)[field] or field == "env.time"
    disputed = evidence[field]
    assert {ANSWER, READER} <= {each.source for each in disputed.disputed}
    assert {flat(false).get(field), flat(TRUTH)[field]} <= {each.value for each in disputed.disputed}
    _, honest = settled_with(TRUTH, reading())
    assert field not in honest or disputed.confidence < honest[field].confidence
    assert disputed.reason.startswith("disputed: kept what ")


def test_where_the_reader_is_less_sure_the_answer_is_kept_and_still_disputed():
    false = changed(num_lanes=2)
    checks = check(false, reading(num_lanes=0.7))
    assert "num_lanes: you answered 2; the embedded reader says 4" in objections(checks)["num_lanes"]
    settled, evidence = settle(false, [*checks.values()], reading(), SUMMARY)
    assert settled.road.lanes == 2
    assert evidence["num_lanes"].reason == "disputed: kept what the model's answer says, against the embedded reader"
    assert 0.5 < evidence["num_lanes"].confidence < 0.8


@pytest.mark.parametrize(("confidence", "is_heard"), [(0.1, False), (0.25, False), (0.45, True)])
def test_a_reader_that_guesses_is_not_heard(confidence, is_heard):
    checks = check(changed(num_lanes=2), reading(num_lanes=confidence))
    assert bool(objections(checks)) is bool(checks["num_lanes"].against) is is_heard


def test_what_the_sketch_shows_is_told_as_such():
    read = reading()
    shown = replace(read.evidence["num_lanes"], box=(1.0, 2.0, 30.0, 40.0))
    told = objections(check(changed(num_lanes=2), replace(read, evidence={**read.evidence, "num_lanes": shown})))
    assert told == {"num_lanes": "num_lanes: you answered 2; the embedded reader of the sketch says 4"}


def test_what_the_reader_does_not_find_it_says_nothing_of():
    silent = reading(changed(num_lanes=None, env__weather=None, collisions=[]))
    assert objections(check(TRUTH, silent)) == {}


@pytest.mark.parametrize(
    ("mine", "theirs"),
    [
        ({"env__weather": "Sunny"}, {"env__weather": "Clear"}),
        ({"env__weather": "Cloudy"}, {"env__weather": "Overcast"}),
        ({"vehicles__0__speed_limit_mph": 40}, {"vehicles__0__speed_limit_mph": 39.8}),
        ({"vehicles__0__manoeuvre": None}, {"vehicles__0__manoeuvre": "Stop"}),
    ],
)
def test_other_words_for_the_same(mine, theirs):
    assert objections(check(changed(**mine), reading(changed(**theirs)))) == {}


class TestTheMetaMessage:
    """What the model itself answered before."""

    @pytest.mark.parametrize(
        ("meta", "field"),
        [
            (replace(META_MESSAGE, road_type=RoadType.STRAIGHT), "road_type"),
            (replace(META_MESSAGE, directions=(Position.E2W, Position.N2S)), "vehicles[1].initial_position"),
            (replace(META_MESSAGE, directions=(Position.E2W,)), "vehicles"),
        ],
    )
    def test_it_speaks_against_a_scenario_of_which_nobody_else_speaks(self, meta, field):
        assert META in objections(check(TRUTH, None, meta))[field]
        confirmed = check(TRUTH, reading(), meta)
        assert objections(confirmed) == {}  # the reader has it as the scenario
        assert confirmed[field].against, "and yet the result says that the meta message was otherwise"

    def test_it_is_held_against_the_reader_itself(self):
        lie = replace(META_MESSAGE, road_type=RoadType.CURVE)
        (found,) = AnswerCheck(CrashReport("case", SUMMARY), reading()).of_meta(lie)
        assert (found.field, found.kept) == ("road_type", "Intersection")
        assert AnswerCheck(CrashReport("case", SUMMARY), None).of_meta(lie) == []

    def test_the_compass_is_no_contradiction_to_a_ramp(self):
        merging = parse_data(
            dump_data(TRUTH)
            | {
                "road_type": "Merging",
                "vehicles": [
                    vehicle | {"initial_position": place}
                    for vehicle, place in zip(dump_data(TRUTH)["vehicles"], ("On-ramp", "Main road"), strict=True)
                ],
                "collisions": [],
            },
            "merging",
        )
        assert objections(check(merging, None, replace(META_MESSAGE, road_type=RoadType.MERGING))) == {}


def test_geometry_speaks_against_all_that_it_takes():
    false = changed(collisions__0__struck_side="Left")
    told = objections(check(false, None))
    assert {"collisions[0].struck_side", "vehicles[0].action"} <= told.keys()
    assert "cannot meet the Left" in told["collisions[0].struck_side"]
    confirmed = changed(collisions__0__struck_side="Left")
    told = objections(check(confirmed, reading()))
    assert {*told} == {"collisions[0].struck_side"}  # of the others the reader is sure
    assert GEOMETRY in {each.source for each in check(false, reading())["vehicles[0].action"].said}


def test_what_the_text_has_no_word_for_was_made_up_unless_a_sketch_may_show_it():
    rainy = changed(env__weather="Rainy", vehicles__0__speed_limit_mph=55)
    told = objections(check(rainy, None, None))
    assert told == {
        "env.weather": "env.weather: you answered Rainy; the text has no word for Rainy",
        "vehicles[0].speed_limit_mph": "vehicles[0].speed_limit_mph: you answered 55; the text has no such number",
    }
    assert TEXT in {each.source for each in check(rainy, None, None)["env.weather"].said}
    assert objections(check(rainy, None, None, sketch=Image(b"", "image/png"))) == {}


class TestCounts:
    """More vehicles or contacts in the one than in the other."""

    def test_a_vehicle_that_was_left_out_is_told_and_what_is_left_still_compared(self):
        data = dump_data(TRUTH)
        false = parse_data(data | {"vehicles": data["vehicles"][:1], "collisions": [], "num_lanes": 2}, "false")
        told = objections(check(false, reading()))
        assert {"vehicles", "collisions", "num_lanes"} <= told.keys()
        settled, evidence = settled_with(false, reading())
        assert settled == TRUTH
        assert evidence["vehicles"].value == 2
        assert {each.value for each in evidence["vehicles"].disputed} == {1, 2}
        assert evidence.keys() >= flat(settled).keys()
        assert "the embedded reader's" in evidence["vehicles[1].model"].reason

    @pytest.mark.parametrize("impacts", [[], [{"striking": 2, "object": "Pole"}]])
    def test_a_vehicle_that_was_made_up_goes_with_all_that_it_struck(self, impacts):
        data = dump_data(TRUTH)
        truth = parse_data(data | {"impacts": impacts}, "truth")
        vehicles = [data["vehicles"][0], *data["vehicles"]]
        made_up = [{"striking": 3, "object": "Tree"}, {"striking": 1, "object": "Sign"}]
        false = parse_data(data | {"vehicles": vehicles, "impacts": made_up}, "false")
        settled, evidence = settled_with(false, reading(truth))
        assert settled == truth
        assert evidence.keys() >= flat(settled).keys()

    def test_contacts_of_vehicles_in_another_order_get_their_numbers(self):
        data = dump_data(TRUTH)
        unnumbered = "A sedan going west at 40 mph hit the right side of a pickup going north in the sun."
        read = reading(
            parse_data(
                data
                | {
                    "vehicles": data["vehicles"][::-1],
                    "collisions": [data["collisions"][0] | {"striking": 2, "struck": 1}],
                },
                "read",
            )
        )
        without = changed(collisions=[])
        settled, evidence = settled_with(without, read, summary=unnumbered)
        assert settled == TRUTH
        assert evidence["collisions"].disputed

    def test_positions_that_no_road_has_together_are_put_in_one_by_one(self):
        merging = reading(
            parse_data(
                {
                    **dump_data(TRUTH),
                    "road_type": "Merging",
                    "num_lanes": 6,
                    "collisions": [],
                    "vehicles": [each | {"initial_position": "Main road"} for each in dump_data(TRUTH)["vehicles"]],
                },
                "merging",
            ),
            **{"vehicles[0].initial_position": 0.3, "vehicles[1].initial_position": 0.3},
        )
        checks = check(TRUTH, merging, None)
        settled, evidence = settle(TRUTH, [*checks.values()], merging, SUMMARY)
        assert settled.road.road_type == "Intersection"
        assert settled.road.lanes == 6
        assert evidence["road_type"].disputed


def test_belief_is_the_product_of_what_each_gives_a_value():
    sources = (Witness(ANSWER, 2, 0.8), Witness(READER, 4, 0.9))
    found = FieldCheck("num_lanes", sources)  # of six values, to which each leaves the rest in equal parts
    weights = {2: 0.8 * 0.1 / 5, 4: 0.9 * 0.2 / 5}
    total = sum(weights.values()) + 4 * (0.1 / 5) * (0.2 / 5)
    assert found.belief(2) == pytest.approx(weights[2] / total)
    assert found.belief(4) == pytest.approx(weights[4] / total)
    assert found.kept == 4
    assert FieldCheck("num_lanes", sources[:1]).belief(2) == pytest.approx(0.8)
    doubted = FieldCheck("num_lanes", (sources[0], Witness(GEOMETRY, None, 0.7)))
    assert doubted.belief(2) == pytest.approx(0.8 * 0.3 / (0.8 * 0.3 + 0.2 * 0.7))
    certain = FieldCheck("num_lanes", (sources[0], Witness(READER, 4, 1.0)))
    assert 0.0 < certain.belief(2) < 0.1
    assert (
        FieldCheck("env.weather", (Witness(ANSWER, "Clear", 0.8), Witness(READER, "Sunny", 0.9))).belief("Clear") > 0.9
    )


def test_points_in_place_of_an_action_are_a_value_too():
    points = changed(vehicles__0__action=[[0, 0], [9, 1]])
    checks = check(points, reading())
    assert "vehicles[0].action" in objections(checks)
    settled, _ = settle(points, [*checks.values()], reading(), SUMMARY)
    assert settled.vehicles[0].action == "Move Forward"
