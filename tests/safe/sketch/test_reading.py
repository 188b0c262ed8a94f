"""A sketch as a whole: drawn here, read there."""

import pytest

from roadmend.safe.claims import CastMember, ClaimSource
from roadmend.safe.dsl import DslModel, Position, Time, Weather

pytest.importorskip("cv2", reason="needs the extra sketch")

from roadmend.safe.sketch.claims import claims_of
from roadmend.safe.sketch.drawing import drawn_over
from roadmend.safe.sketch.reading import read_sketch

from .drawings import BLUE, GREEN, RED, Drawing

PAIR = (CastMember(1, ("v1",), DslModel.SEDAN), CastMember(2, ("v2",), DslModel.SEMI_TRUCK))


def crossing():
    """Vehicle 1 comes from the left, vehicle 2 from below; they meet in the middle; up is up."""
    drawing = Drawing()
    drawing.line(0, 280, 440, 280).line(0, 380, 440, 380).line(560, 280, 1000, 280).line(560, 380, 1000, 380)
    drawing.line(440, 0, 440, 280).line(440, 380, 440, 700).line(560, 0, 560, 280).line(560, 380, 560, 700)
    drawing.vehicle(90, 350, 0, RED, "V1").vehicle(280, 350, 0, RED, "V1").vehicle(470, 350, 0, RED, "V1")
    drawing.vehicle(545, 600, 90, BLUE, "V2").vehicle(548, 390, 90, BLUE, "V2")
    return drawing


def claimed(drawing, cast=PAIR, kind="png"):
    return {claim.path: claim for claim in claims_of(read_sketch(drawing.sketch(kind)), cast)}


@pytest.mark.parametrize(
    ("north", "first", "second"),
    [
        (90, Position.W2E, Position.S2N),
        (0, Position.S2N, Position.E2W),
        (180, Position.N2S, Position.W2E),
        (-90, Position.E2W, Position.N2S),
    ],
)
def test_ways_by_the_compass(north, first, second):
    claims = claimed(crossing().compass(850, 110, 60, north))
    assert claims["vehicles[0].initial_position"].value is first
    assert claims["vehicles[1].initial_position"].value is second
    assert all(claim.source is ClaimSource.SKETCH and claim.where is not None for claim in claims.values())


def test_without_north_there_are_no_ways():
    assert not any(path.endswith("initial_position") for path in claimed(crossing()))


@pytest.mark.parametrize("kind", ["png", "jpeg"])
def test_a_letter_beside_an_arrow_is_north(kind):
    drawing = crossing().arrow((800, 100), (880, 100)).text(895, 80, "N", 36)
    reading = read_sketch(drawing.sketch(kind))
    assert reading.north is not None
    assert reading.north.heading == pytest.approx(0.0, abs=5.0)


def test_two_norths_that_disagree_are_none():
    drawing = crossing().compass(850, 110, 60, 90).compass(850, 560, 60, 0)
    assert read_sketch(drawing.sketch()).north is None


def test_numbers_and_fronts():
    reading = read_sketch(crossing().sketch())
    numbers = sorted((pose.number, round(pose.heading)) for pose in reading.poses)
    assert [number for number, _ in numbers] == [1, 1, 1, 2, 2]
    assert all(min(heading % 360, 360 - heading) < 5 for number, heading in numbers if number == 1)
    assert all(abs(heading - 90) < 5 for number, heading in numbers if number == 2)


def test_an_arrow_tells_the_way_where_no_triangle_does():
    drawing = Drawing().vehicle(300, 300, 0, GREEN, "V1", triangle=False).arrow((370, 300), (470, 300))
    drawing.vehicle(560, 300, 0, GREEN, "V1", triangle=False).compass(850, 110, 60, 90)
    claims = claimed(drawing, PAIR[:1])
    assert claims["vehicles[0].initial_position"].value is Position.W2E


def test_a_vehicle_drawn_once_without_a_sign_has_no_way():
    drawing = Drawing().vehicle(300, 300, 0, RED, "V1", triangle=False).compass(850, 110, 60, 90)
    assert claimed(drawing, PAIR[:1]) == {}


def test_a_way_between_two_directions_is_not_claimed():
    drawing = Drawing().vehicle(200, 500, 45, RED, "V1").vehicle(400, 300, 45, RED, "V1").compass(850, 110, 60, 90)
    assert claimed(drawing, PAIR[:1]) == {}


def test_limits_for_cars_and_trucks_go_by_the_body():
    drawing = Drawing().text(100, 600, "Speed limit 70 mph for cars, 55 mph for trucks", 30)
    claims = claimed(drawing)
    assert claims["vehicles[0].speed_limit_mph"].value == 70
    assert claims["vehicles[1].speed_limit_mph"].value == 55


def test_limits_for_two_roads_go_by_the_way():
    drawing = crossing().compass(850, 110, 60, 90)
    drawing.text(60, 60, "E/W speed limit 45 mph", 26).text(60, 120, "N/S speed limit 30 mph", 26)
    claims = claimed(drawing)
    assert claims["vehicles[0].speed_limit_mph"].value == 45
    assert claims["vehicles[1].speed_limit_mph"].value == 30


def test_two_limits_that_are_for_nobody_are_not_claimed():
    drawing = Drawing().text(60, 60, "Speed limit 45 mph", 26).text(60, 220, "Speed limit 30 mph", 26)
    assert claimed(drawing) == {}


def test_light_and_weather():
    claims = claimed(Drawing().text(60, 60, "Dry, daylight, clear", 30))
    assert claims["env.time"].value is Time.DAYTIME
    assert claims["env.weather"].value is Weather.SUNNY


def test_an_hour_is_a_time():
    claims = claimed(Drawing().text(60, 60, "Time: 0330 hours", 30))
    assert claims["env.time"].value is Time.NIGHTTIME


def test_one_word_alone_is_no_weather():
    assert claimed(Drawing().text(60, 60, "Rain gutter", 30)) == {}


def test_places_are_in_pixels_of_the_file():
    drawing = Drawing(4000, 2800).text(2400, 2000, "Speed limit 45 mph", 120)
    box = claimed(drawing)["vehicles[0].speed_limit_mph"].where
    assert 2300 < box.left < 2500
    assert 1900 < box.top < 2150


def test_the_same_file_gives_the_same_reading():
    sketch = crossing().compass(850, 110, 60, 90).sketch()
    first = claims_of(read_sketch(sketch), PAIR)
    read_sketch.cache_clear()
    assert claims_of(read_sketch(sketch), PAIR) == first


def test_an_empty_sheet():
    reading = read_sketch(Drawing().sketch())
    assert reading.account() == "read: 0 words, 0 posted limits, no vehicle's number, no north; lanes were not"
    assert claims_of(reading, PAIR) == ()


def test_what_was_read_is_drawn_over():
    data = drawn_over(read_sketch(crossing().compass(850, 110, 60, 90).sketch()))
    assert data.startswith(b"\x89PNG")
