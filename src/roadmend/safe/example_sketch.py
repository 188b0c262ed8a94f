"""The sketches of the worked examples, drawn from what the examples say: ``python -m roadmend.safe.example_sketch``.

They look like those that investigators draw: the road from above, each vehicle where it came from with its number and its
way to the contact, a star there, the posted limit and an arrow to the north. The pictures are kept as files, since a
drawing would differ with the libraries, and with it every recorded exchange.
"""

import io
import math
from collections.abc import Sequence
from pathlib import Path

import PIL.Image
import PIL.ImageDraw
import PIL.ImageFont

from roadmend.core.whole_file import written_beside
from roadmend.safe.compass import HEADING, NORTH_SOUTH, TURN
from roadmend.safe.dsl import Action, Compass, CrashScenario, DescribedVehicle, Manoeuvre, Position, RoadType
from roadmend.safe.knowledge_base import templates

Point = tuple[float, float]  # [m] east and north of the middle

_SIZE = 480  # [pixels] of a side
_METRE = 5.0  # [pixels]
_FINER = 3  # times, to draw without steps
_HALF = 48.0  # [m] from the middle to the edge
_LANE = 3.7  # [m]
_BEND = 45.0  # [m] radius of a curve
_COLOURS = ((30, 90, 200), (200, 60, 40), (40, 140, 70))  # of the vehicles' ways
_ROAD, _GRASS, _PAINT, _INK = (170, 170, 170), (255, 255, 255), (250, 250, 250), (20, 20, 20)
_SIZES = {"Semi Truck": (16.0, 2.6)}  # [m] length and width, where it is no car
_CAR = (4.6, 1.9)


def draw_sketch(crash: CrashScenario) -> bytes:
    """The sketch of a crash of two vehicles as a PNG file."""
    side = _SIZE * _FINER
    image = PIL.Image.new("RGB", (side, side), _GRASS)
    pen = _Pen(PIL.ImageDraw.Draw(image))
    _draw_roads(pen, crash)
    meeting = _meeting(crash)
    for number, vehicle in enumerate(crash.vehicles, start=1):
        _draw_vehicle(pen, crash, vehicle, number, meeting)
    star = [(meeting[0] + r * math.cos(a), meeting[1] + r * math.sin(a)) for r, a in _STAR]
    pen.draw.polygon([pen.place(point) for point in star], fill=(255, 200, 0), outline=_INK)
    _draw_legend(pen, crash)
    small = image.resize((_SIZE, _SIZE), PIL.Image.Resampling.LANCZOS).quantize(64, PIL.Image.Quantize.MAXCOVERAGE)
    data = io.BytesIO()
    small.save(data, "png", optimize=True)
    return data.getvalue()


_STAR = [((3.0, 1.3)[point % 2], point * math.pi / 8) for point in range(16)]


class _Pen:
    """Draws in metres."""

    def __init__(self, draw: PIL.ImageDraw.ImageDraw) -> None:
        self.draw = draw

    def place(self, point: Point) -> Point:
        scale = _METRE * _FINER
        return (_SIZE * _FINER / 2 + scale * point[0], _SIZE * _FINER / 2 - scale * point[1])

    def line(self, points: Sequence[Point], width: float, colour: tuple[int, int, int]) -> None:
        pixels = max(1, round(width * _METRE * _FINER))
        self.draw.line([self.place(point) for point in points], fill=colour, width=pixels, joint="curve")

    def dashes(self, points: Sequence[Point]) -> None:
        for one, other in zip(points[::2], points[1::2], strict=False):
            self.line([one, other], 0.25, _PAINT)

    def text(self, point: Point, text: str, size: float = 4.0) -> None:
        font = PIL.ImageFont.load_default(size * _METRE * _FINER)
        self.draw.text(self.place(point), text, fill=_INK, font=font, anchor="mm")

    def arrow(self, points: Sequence[Point], colour: tuple[int, int, int]) -> None:
        self.line(points, 0.6, colour)
        (x, y), (ex, ey) = points[-2:]
        heading = math.atan2(ey - y, ex - x)
        head = [(ex + 2.2 * math.cos(heading + turn), ey + 2.2 * math.sin(heading + turn)) for turn in (2.7, -2.7)]
        self.draw.polygon([self.place(point) for point in ((ex, ey), *head)], fill=colour)


def _draw_roads(pen: _Pen, crash: CrashScenario) -> None:
    lanes = crash.road.lanes or 2
    match crash.road.road_type:
        case RoadType.CURVE:
            _draw_road(pen, _curve(0.0), [_curve(offset) for offset in _marks(lanes)], lanes)
        case RoadType.INTERSECTION:
            for axis in (0.0, 90.0):
                _draw_straight(pen, axis, _lanes_on(crash, axis), (-_HALF, _HALF))
        case RoadType.T_INTERSECTION:
            bearing = {Compass.EAST: 0.0, Compass.NORTH: 90.0, Compass.WEST: 180.0, Compass.SOUTH: 270.0}
            stem = bearing[crash.road.stem or Compass.SOUTH]
            _draw_straight(pen, stem, 2, (0.0, _HALF))
            _draw_straight(pen, stem + 90.0, lanes, (-_HALF, _HALF))
        case RoadType.MERGING:
            pen.line(_ramp(), _LANE, _ROAD)
            pen.line([(-10.0, _ramp_end()), (_HALF, _ramp_end())], _LANE, _ROAD)
            _draw_straight(pen, 0.0, lanes, (-_HALF, _HALF))
        case _:
            first = crash.vehicles[0].initial_position or Position.W2E
            _draw_straight(pen, float(HEADING[first]), lanes, (-_HALF, _HALF))


def _lanes_on(crash: CrashScenario, axis: float) -> int:
    """Lanes of one of two crossing roads: the smaller one is that with the lower limit."""
    limits = {HEADING[v.initial_position] % 180: v.speed_limit_mph or 0 for v in crash.vehicles if v.initial_position}
    is_smaller = limits.get(int(axis), max(limits.values())) < max(limits.values())
    return 2 if is_smaller else crash.road.lanes or 2


def _draw_straight(pen: _Pen, heading: float, lanes: int, reach: tuple[float, float]) -> None:
    def line(offset: float) -> list[Point]:
        steps = [reach[0] + (reach[1] - reach[0]) * step / 32 for step in range(33)]
        return [_at(heading, along, offset) for along in steps]

    _draw_road(pen, line(0.0), [line(offset) for offset in _marks(lanes)], lanes)


def _draw_road(pen: _Pen, middle: Sequence[Point], marks: Sequence[Sequence[Point]], lanes: int) -> None:
    pen.line(middle, _LANE * lanes, _ROAD)
    for mark in marks:
        pen.dashes(mark)


def _marks(lanes: int) -> list[float]:
    """Where the lines between lanes run [m] beside the middle."""
    return [_LANE * (number - lanes / 2) for number in range(1, lanes)]


def _at(heading: float, along: float, right: float) -> Point:
    """A point ahead of the middle and to the right of it [m], as one sees it who drives at a heading [deg]."""
    angle = math.radians(heading)
    east, north = math.cos(angle), math.sin(angle)
    return (along * east + right * north, along * north - right * east)


def _curve(offset: float) -> list[Point]:
    """A bend whose middle lies in the middle of the picture, with its centre to the east."""
    angles = [math.radians(180.0 + step) for step in range(-60, 61, 4)]
    radius = _BEND - offset
    return [(_BEND + radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]


def _ramp_end() -> float:
    return -2.5 * _LANE


def _ramp() -> list[Point]:
    return [(-46.0, -34.0), (-30.0, -20.0), (-18.0, _ramp_end() - 1.0), (-10.0, _ramp_end())]


def _offset(crash: CrashScenario, vehicle: DescribedVehicle) -> float:
    """How far to the right of the middle a vehicle drives [m]: in the outermost lane of its direction, to turn left in the inmost."""
    lanes = crash.road.lanes or 2
    if vehicle.initial_position in HEADING and crash.road.road_type is RoadType.INTERSECTION:
        lanes = _lanes_on(crash, HEADING[vehicle.initial_position] % 180)
    is_stem = (vehicle.initial_position in NORTH_SOUTH) == (crash.road.stem in {Compass.NORTH, Compass.SOUTH})
    if crash.road.stem is not None and is_stem:
        lanes = 2
    outermost = lanes // 2 - 0.5
    return _LANE * (0.5 if vehicle.action is Action.TURN_LEFT else outermost)


def _heading(vehicle: DescribedVehicle) -> float:
    return float(HEADING[vehicle.initial_position or Position.W2E])


def _meeting(crash: CrashScenario) -> Point:
    """Where the first two vehicles touch."""
    one, other = crash.vehicles[:2]
    if one.manoeuvre is Manoeuvre.ENTER_THE_WRONG_WAY:
        one, other = other, one  # it is in the lane of the one that keeps to its side
    own = _at(_heading(one), 0.0, _offset(crash, one))
    if crash.road.road_type is RoadType.MERGING or (_heading(one) - _heading(other)) % 180 == 0:
        if Action.TURN_LEFT in {one.action, other.action}:
            straight = other if one.action is Action.TURN_LEFT else one
            return _at(_heading(straight), -2.0, _offset(crash, straight))
        return own
    theirs = _at(_heading(other), 0.0, _offset(crash, other))
    return (own[0], theirs[1]) if one.initial_position in NORTH_SOUTH else (theirs[0], own[1])


def _draw_vehicle(pen: _Pen, crash: CrashScenario, vehicle: DescribedVehicle, number: int, meeting: Point) -> None:
    heading, offset = _heading(vehicle), _offset(crash, vehicle)
    length, width = _SIZES.get(vehicle.model or "", _CAR)
    colour = _COLOURS[(number - 1) % len(_COLOURS)]
    start = _at(heading, -34.0, offset)
    way = [start, meeting]
    if vehicle.initial_position is Position.ON_RAMP:
        way = [*_ramp()[1:], (meeting[0] - 6.0, _ramp_end()), meeting]
        start, heading = way[0], 40.0
    elif crash.road.road_type is RoadType.CURVE:
        # From north to south the curve bends to the left, so that the right lane is the outer one.
        bend = _curve(-offset) if vehicle.initial_position is Position.N2S else _curve(offset)[::-1]
        way = [*bend[3 : len(bend) // 2 - 1], meeting]
        start = way[0]
        heading = math.degrees(math.atan2(way[1][1] - start[1], way[1][0] - start[0]))
    elif vehicle.manoeuvre is Manoeuvre.STOP:
        back = _at(heading, length / 2 + 1.0, 0.0)
        start = (meeting[0] + back[0], meeting[1] + back[1])
        way = []
    elif isinstance(vehicle.action, Action) and TURN[vehicle.action]:
        way = [start, _at(heading, -10.0, offset), meeting]
    elif vehicle.manoeuvre is Manoeuvre.ENTER_THE_WRONG_WAY:
        way = [start, _at(heading, -16.0, offset), meeting]
    if way:
        pen.arrow(way, colour)
    corners = [(length / 2, width / 2), (length / 2, -width / 2), (-length / 2, -width / 2), (-length / 2, width / 2)]
    body = [_at(heading, along, right) for along, right in corners]
    pen.draw.polygon(
        [pen.place((start[0] + x, start[1] + y)) for x, y in body], fill=colour, outline=_INK, width=_FINER
    )
    beside = _at(heading, 0.0, 5.0)
    pen.text((start[0] + beside[0], start[1] + beside[1]), f"V{number}")


def _draw_legend(pen: _Pen, crash: CrashScenario) -> None:
    pen.arrow([(41.0, 34.0), (41.0, 44.0)], _INK)
    pen.text((41.0, 31.0), "N")
    limits = sorted({vehicle.speed_limit_mph for vehicle in crash.vehicles if vehicle.speed_limit_mph is not None})
    if limits:
        pen.text((26.0, -44.0), f"Speed limit {' / '.join(f'{limit:g}' for limit in limits)} mph", 3.2)


def main() -> None:
    """Draw the sketch of every example into the folder of the knowledge base."""
    folder = Path(__file__).parent / "knowledge"
    for template in templates().values():
        for example in template.examples:
            with written_beside(folder / example.picture) as path:
                path.write_bytes(draw_sketch(example.answer))


if __name__ == "__main__":
    main()
