"""Markers: complete pictures, exact outlines, finite numbers, and what stands out in them."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from visualization_msgs.msg import Marker

from roadmend.core.appearance import KIND_COLOUR, KIND_HEIGHT, STATUS_COLOUR, TRIGGER_COLOUR
from roadmend.core.command import Command, Trajectory
from roadmend.core.geometry import fill_corners
from roadmend.core.repair import Repair, RepairStatus, RepairTrigger
from roadmend.core.route import RightOfWay, Route, Stage, Window, Zone
from roadmend.core.scene import EgoState, ObjectKind, ObjectList
from roadmend.recording.marker_map import band_edges, map_markers
from roadmend.recording.marker_parts import Shape, colour_of
from roadmend.recording.markers import (
    caption_of,
    ego_markers,
    object_markers,
    path_of,
    plan_markers,
    signal_markers,
    transform_of,
)
from roadmend.recording.messages import header_of
from roadmend.world.road_network import LaneMap

HEADER = header_of(12.35)
EGO = EgoState.from_yaw(3.0, 4.0, 0.7, 8.0, 0.0, 4.8, 1.8)


def objects_at(*rows: tuple[int, ObjectKind, float, float, float]) -> ObjectList:
    """Objects given by id, kind, x, y and yaw; 4 m by 2 m at 5 m/s."""
    number, kind, x, y, yaw = np.array(rows, dtype=np.float64).reshape(-1, 5).T
    return ObjectList.of(
        id=number,
        kind=kind,
        x=x,
        y=y,
        yaw=yaw,
        speed=5.0,
        acceleration=0.0,
        yaw_rate=0.0,
        length=4.0,
        width=2.0,
    )


def route() -> Route:
    """Two parallel stages of 100 m, a window between them, a light on the first."""
    x, limit = np.array([0.0, 40.0, 100.0]), np.full(3, 13.9)
    stages = (Stage(x, np.zeros(3), limit), Stage(x.copy(), np.full(3, 3.2), limit))
    zone = Zone(0, 60.0, 75.0, RightOfWay.SIGNAL, 0)
    return Route("two lanes", 4.8, 1.8, 90.0, 60.0, stages, (Window(10.0, 30.0),), (zone,))


def plan() -> Trajectory:
    """Three points straight ahead."""
    return Trajectory(0.5, np.array([4.0, 8.0, 12.0]), np.zeros(3), np.zeros(3), np.full(3, 8.0), "follow")


def lane_map(count: int = 4) -> LaneMap:
    """Lanes of three points each, kinds in turn."""
    lane = np.arange(count)
    return LaneMap(
        3 * lane,
        (lane % 3).astype(np.uint8),
        np.full(count, 3.2),
        np.tile([0.0, 10.0, 20.0], count),
        np.repeat(3.2 * lane, 3),
    )


def repair(**changes: object) -> Repair:
    """A repair with a reason."""
    known = Repair(
        Command(0.0, 0.8), RepairStatus.REPAIRED, 0.9, 0.5, 0.4, -0.8, True, 0, (RepairTrigger(2, 1.0),), "car 2 ahead"
    )
    return replace(known, **changes)


def in_namespace(markers: Any, namespace: str) -> list[Any]:
    """The markers of one namespace."""
    return [marker for marker in markers.markers if marker.ns == namespace]


def numbers_of(markers: Any) -> list[float]:
    """Every number that places or sizes something."""
    found: list[float] = []
    for marker in markers.markers:
        vectors = (marker.pose.position, marker.scale, *marker.points)
        found += [part for vector in vectors for part in (vector.x, vector.y, vector.z)]
        turn = marker.pose.orientation
        found += [turn.x, turn.y, turn.z, turn.w]
    return found


def every_picture() -> dict[str, Any]:
    """One of each kind of picture."""
    objects = objects_at((1, ObjectKind.CAR, 0.0, 9.0, 0.3), (2, ObjectKind.BUS, 20.0, 0.0, -1.0))
    return {
        "objects": object_markers(objects, EGO, HEADER, triggers=frozenset({2})),
        "ego": ego_markers(EGO, repair(), HEADER),
        "plan": plan_markers(plan(), EGO, HEADER),
        "map": map_markers(lane_map(), route(), HEADER),
        "no objects": object_markers(ObjectList.empty(), EGO, HEADER),
        "no state": ego_markers(EGO, None, HEADER),
        "no plan": plan_markers(Trajectory.empty(), EGO, HEADER),
        "no map": map_markers(None, None, HEADER),
    }


@pytest.mark.parametrize("name", every_picture())
def test_each_picture_stands_for_itself(name: str) -> None:
    markers = every_picture()[name].markers
    assert markers[0].action == Marker.DELETEALL
    assert all(marker.action == Marker.ADD for marker in markers[1:])
    assert all(marker.header == HEADER for marker in markers)
    assert all(math.isfinite(number) for number in numbers_of(every_picture()[name]))
    names = [(marker.ns, marker.id) for marker in markers[1:]]
    assert len(names) == len(set(names))
    for marker in markers:
        assert len(marker.colors) in {0, len(marker.points)}
        if marker.type == Marker.LINE_LIST:
            assert len(marker.points) % 2 == 0
        if marker.type == Marker.TRIANGLE_LIST:
            assert len(marker.points) % 3 == 0


@pytest.mark.parametrize("kind", list(ObjectKind))
def test_box_has_colour_and_size_of_its_kind(kind: ObjectKind) -> None:
    markers = object_markers(objects_at((7, kind, 10.0, -2.0, 0.5)), EGO, HEADER)
    (box,) = in_namespace(markers, "objects")
    assert box.type == Marker.CUBE
    assert box.color == colour_of(KIND_COLOUR[kind], 0.85)
    assert (box.scale.x, box.scale.y, box.scale.z) == (4.0, 2.0, KIND_HEIGHT[kind])
    assert box.pose.position.z == 0.5 * KIND_HEIGHT[kind]
    assert 2.0 * math.atan2(box.pose.orientation.z, box.pose.orientation.w) == pytest.approx(0.5)


def test_outline_has_the_exact_corners() -> None:
    corners = np.empty((4, 2))
    fill_corners(corners, 10.0, -2.0, 0.5, 4.0, 2.0)
    expected = [tuple(corner) for corner in corners]
    one = objects_at((7, ObjectKind.CAR, 10.0, -2.0, 0.5))
    (outline,) = in_namespace(object_markers(one, EGO, HEADER), "outlines")
    drawn = [(point.x, point.y) for point in outline.points]
    assert drawn[0::2] == expected
    assert drawn[1::2] == [*expected[1:], expected[0]]
    (outline,) = in_namespace(object_markers(one, EGO, HEADER, triggers=frozenset({7})), "triggers")
    assert [(point.x, point.y) for point in outline.points] == [*expected, expected[0]]


def test_trigger_is_red_thick_and_named_at_any_distance() -> None:
    objects = objects_at((1, ObjectKind.CAR, 10.0, 0.0, 0.0), (2, ObjectKind.CAR, 500.0, 0.0, 0.0))
    markers = object_markers(objects, EGO, HEADER, triggers=frozenset({2}), text_radius=5.0)
    boxes = {marker.id: marker for marker in in_namespace(markers, "objects")}
    assert boxes[2].color == colour_of(TRIGGER_COLOUR)
    assert boxes[1].color != boxes[2].color
    (thin,), (thick,) = in_namespace(markers, "outlines"), in_namespace(markers, "triggers")
    assert thick.scale.x > 2.0 * thin.scale.x
    assert [marker.text for marker in in_namespace(markers, "labels")] == ["2  5.0 m/s"]


def test_text_only_near_the_ego() -> None:
    objects = objects_at((1, ObjectKind.CAR, 3.0, 43.0, 0.0), (2, ObjectKind.CAR, 3.0, 45.0, 0.0))
    markers = object_markers(objects, EGO, HEADER, text_radius=40.0)
    assert [marker.id for marker in in_namespace(markers, "labels")] == [1]


@pytest.mark.parametrize("bad", [math.nan, math.inf])
@pytest.mark.parametrize("column", ["x", "y", "yaw", "speed", "length", "width"])
def test_objects_that_are_not_finite_are_left_out(column: str, bad: float) -> None:
    objects = objects_at((1, ObjectKind.CAR, 1.0, 1.0, 0.0), (2, ObjectKind.CAR, 9.0, 1.0, 0.0))
    getattr(objects, column)[0] = bad
    markers = object_markers(objects, EGO, HEADER)
    assert [marker.id for marker in in_namespace(markers, "objects")] == [2]
    assert all(math.isfinite(number) for number in numbers_of(markers))


def test_an_unknown_kind_and_the_largest_id_are_drawn() -> None:
    objects = objects_at((2**32 - 1, ObjectKind.CAR, 1.0, 1.0, 0.0))
    objects.kind[0] = 200
    (box,) = in_namespace(object_markers(objects, EGO, HEADER), "objects")
    assert box.color == colour_of(KIND_COLOUR[ObjectKind.UNKNOWN], 0.85)


@pytest.mark.parametrize("status", list(RepairStatus))
def test_ego_wears_the_colour_of_the_repair_state(status: RepairStatus) -> None:
    box = in_namespace(ego_markers(EGO, repair(status=status), HEADER), "ego")[0]
    assert box.color == colour_of(STATUS_COLOUR[status])


def test_ego_text_accounts_for_an_intervention() -> None:
    lines = caption_of(EGO, repair()).splitlines()
    assert lines == ["REPAIRED  8.0 m/s", "score 0.90 > 0.50", "action +0.40 -> -0.80", "car 2 ahead"]
    assert caption_of(EGO, repair(worth=0.4)).splitlines()[2] == "action +0.40 -> -0.80, worth +0.40 collisions"


def test_ego_text_without_score_and_without_command() -> None:
    stale = repair(
        status=RepairStatus.STALE_COMMAND, score=math.nan, threshold=math.nan, policy_action=math.nan, reason=""
    )
    assert caption_of(EGO, stale).splitlines() == ["STALE_COMMAND  8.0 m/s", "action none -> -0.80"]
    assert caption_of(EGO, repair(status=RepairStatus.PASS, intervened=False, score=0.2)).splitlines() == [
        "PASS  8.0 m/s",
        "score 0.20 <= 0.50",
    ]


def test_plan_begins_at_the_ego_and_has_a_sphere_for_each_point() -> None:
    markers = plan_markers(plan(), EGO, HEADER)
    (line,), (spheres,) = in_namespace(markers, "plan"), in_namespace(markers, "plan_points")
    assert (line.points[0].x, line.points[0].y) == (EGO.x, EGO.y)
    assert [point.x for point in spheres.points] == [4.0, 8.0, 12.0]
    broken = plan()
    broken.x[1] = math.nan
    assert len(in_namespace(plan_markers(broken, EGO, HEADER), "plan_points")[0].points) == 2
    assert len(path_of(broken, HEADER).poses) == 2


def test_path_has_frame_and_time_on_every_pose() -> None:
    path = path_of(plan(), HEADER)
    assert path.header == HEADER
    assert [pose.header.frame_id for pose in path.poses] == ["map"] * 3
    assert [(pose.header.stamp.sec, pose.header.stamp.nanosec) for pose in path.poses] == [
        (12, 850_000_000),
        (13, 350_000_000),
        (13, 850_000_000),
    ]


def test_transform_is_the_pose_of_the_ego() -> None:
    stamped = transform_of(EGO, HEADER)
    assert (stamped.header.frame_id, stamped.child_frame_id) == ("map", "base_link")
    turn = stamped.transform.rotation
    assert (turn.z, turn.w) == (EGO.orientation_z, EGO.orientation_w)


def test_lamp_shows_the_signal() -> None:
    red, unknown = (signal_markers(route(), np.array([code], dtype=np.uint8), HEADER)[0] for code in (2, 99))
    assert (red.pose.position.x, red.pose.position.y) == (60.0, 0.0)
    assert red.color.r > red.color.g > unknown.color.r - 1.0
    assert red.color != unknown.color
    assert signal_markers(route(), np.empty(0, dtype=np.uint8), HEADER) == []


def test_map_has_surfaces_edges_and_the_whole_route() -> None:
    markers = map_markers(lane_map(), route(), HEADER)
    counts = {ns: len(in_namespace(markers, ns)) for ns in {marker.ns for marker in markers.markers[1:]}}
    assert counts == {
        "road": 1,
        "junction": 1,
        "walk": 1,
        "edges": 1,
        "route": 2,
        "windows": 1,
        "zones": 1,
        "stop_lines": 1,
        "goal": 2,
    }
    (road,), (edges,) = in_namespace(markers, "road"), in_namespace(markers, "edges")
    assert len(road.points) == 2 * 2 * 6  # lanes 0 and 3, two segments each, two triangles each
    assert len(edges.points) == 2 * 2 * 4
    (window,) = in_namespace(markers, "windows")
    assert [point.x for point in window.points] == [10.0, 30.0]
    (zone,) = in_namespace(markers, "zones")
    assert [point.x for point in zone.points] == [60.0, 75.0]


def test_triangles_face_up() -> None:
    (road,) = in_namespace(map_markers(lane_map(1), None, HEADER), "road")
    for first, second, third in zip(road.points[0::3], road.points[1::3], road.points[2::3], strict=True):
        area = (second.x - first.x) * (third.y - first.y) - (second.y - first.y) * (third.x - first.x)
        assert area > 0.0


def test_band_keeps_its_width_around_a_bend() -> None:
    x, y = np.array([0.0, 10.0, 10.0]), np.array([0.0, 0.0, 10.0])
    left, right, joined = band_edges(x, y, np.zeros(3, dtype=np.int64), np.full(3, 1.0))
    assert joined.tolist() == [True, True]
    np.testing.assert_allclose(left, [[0.0, 1.0], [9.0, 1.0], [9.0, 10.0]], atol=1e-12)
    np.testing.assert_allclose(right, [[0.0, -1.0], [11.0, -1.0], [11.0, 10.0]], atol=1e-12)


def test_band_survives_hairpins_and_repeated_or_broken_points() -> None:
    x = np.array([0.0, 10.0, 0.0, 0.0, math.nan, 5.0, 6.0])
    left, right, joined = band_edges(x, np.zeros(7), np.array([0, 0, 0, 0, 0, 1, 1]), np.full(7, 1.0))
    assert joined.tolist() == [True, True, False, False, False, True]
    used = np.unique(np.concatenate((np.flatnonzero(joined), np.flatnonzero(joined) + 1)))
    assert np.isfinite(left[used]).all()
    assert np.isfinite(right[used]).all()
    assert np.abs(left[used] - np.column_stack((x, np.zeros(7)))[used]).max() <= 2.0


@pytest.mark.parametrize(
    "change", [{"x": np.zeros(1)}, {"kind": np.zeros(1, dtype=np.uint8)}, {"begin": np.array([3, 0, 6, 9])}]
)
def test_map_that_does_not_fit_together_is_refused(change: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="map: "):
        map_markers(replace(lane_map(), **change), None, HEADER)


@pytest.mark.parametrize("shape", Shape)
def test_shapes_mirror_the_message(shape: Shape) -> None:
    assert getattr(Marker, shape.name) == shape
