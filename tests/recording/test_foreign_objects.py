import math

import numpy as np
import pytest

from roadmend.core.scene import ObjectKind
from roadmend.recording.codec import encode
from roadmend.recording.foreign_objects import Detections, EgoOutline, OwnObjects, ego_pose_of, yaw_of
from roadmend.recording.messages import OBJECTS, QUATERNION

from .foreign_messages import DETECTIONS, detection, detections, header, odometry

CAR = EgoOutline(4.5, 1.8)


def pose_at(time=0.0, **motion):
    return ego_pose_of(odometry(time, **motion), CAR)


def watch(*moments, reader=None, frame="odom", **motion):
    """The last of several lists of detections, 0.1 s apart."""
    reader = reader or Detections()
    for index, those in enumerate(moments):
        objects, signals = reader.read(detections(0.1 * index, *those, frame=frame), pose_at(0.1 * index, **motion))
    assert len(signals) == 0
    return objects


def moving(name="7", speed=5.0, toward=0.0, yaw=None, steps=8, **box):
    heading = toward if yaw is None else yaw
    return [
        [detection(name, 0.1 * step * speed * math.cos(toward), 0.1 * step * speed * math.sin(toward), heading, **box)]
        for step in range(steps)
    ]


def test_the_messages_survive_the_wire():
    message = detections(1.5, detection("7", 1.0, 2.0, 0.3, kinds=[("bus", 0.4), ("car", 0.5)]))
    again = DETECTIONS.decode(encode(message))
    assert again.detections[0].results[1].hypothesis.class_id == "car"
    assert again.detections[0].bbox.center.position.y == 2.0
    assert again.header.stamp.nanosec == 500_000_000


@pytest.mark.parametrize("yaw", [-3.0, -0.5, 0.0, 1.2, 3.1])
def test_yaw_of_any_quaternion_about_the_vertical(yaw):
    for scale in (1.0, -1.0, 0.3):
        assert yaw_of(QUATERNION(z=scale * math.sin(yaw / 2), w=scale * math.cos(yaw / 2))) == pytest.approx(yaw)


def test_yaw_does_not_mind_pitch_and_a_quaternion_of_zeros_has_none():
    yaw, pitch = 0.7, 0.2
    cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    assert yaw_of(QUATERNION(x=-sp * sy, y=sp * cy, z=cp * sy, w=cp * cy)) == pytest.approx(yaw)
    assert math.isnan(yaw_of(QUATERNION(x=0.0, y=0.0, z=0.0, w=0.0)))


def test_the_ego_is_its_centre():
    pose = ego_pose_of(
        odometry(3.0, x=10.0, y=5.0, yaw=0.5 * math.pi, speed=7.0, yaw_rate=0.1), EgoOutline(4.5, 1.8, 1.4)
    )
    assert (pose.ego.x, pose.ego.y) == pytest.approx((10.0, 6.4))
    assert (pose.ego.speed, pose.ego.yaw_rate, pose.ego.length, pose.ego.width) == (7.0, 0.1, 4.5, 1.8)
    assert (pose.frame, pose.base_frame, pose.stamp) == ("odom", "base_link", 3_000_000_000)


class TestDetections:
    @pytest.mark.parametrize("toward", [0.0, 2.5, -1.0])
    def test_speed_comes_from_the_positions(self, toward):
        objects = watch(*moving(speed=5.0, toward=toward))
        assert objects.id.tolist() == [7]
        assert objects.speed[0] == pytest.approx(5.0, abs=1e-6)
        assert objects.yaw[0] == pytest.approx(toward)
        assert (objects.length[0], objects.width[0], objects.kind[0]) == (4.5, 1.8, ObjectKind.CAR)

    def test_who_is_seen_for_the_first_time_does_not_count_yet(self):
        assert len(watch([detection("7", 30.0, 0.0)])) == 0
        objects = watch([detection("7", 30.0, 0.0)], [detection("7", 30.0, 0.0), detection("8", 5.0, 0.0)])
        assert objects.id.tolist() == [7]
        assert objects.speed.tolist() == [0.0]

    @pytest.mark.parametrize("outlier", [60.0, 2000.0, 1e6, 1.7976931348623157e308, -1e8])
    def test_one_place_where_it_cannot_be_spoils_nothing(self, outlier):
        reader = Detections()
        for step in range(6):
            objects, _ = reader.read(detections(0.1 * step, detection("7", 12.0, 0.0)), pose_at(0.1 * step))
        objects, _ = reader.read(detections(0.6, detection("7", outlier, 0.0)), pose_at(0.6))
        assert (objects.x[0], objects.speed[0]) == (outlier, 0.0)
        for step in range(7, 9):
            objects, _ = reader.read(detections(0.1 * step, detection("7", 12.0, 0.0)), pose_at(0.1 * step))
            assert (objects.x[0], objects.speed[0]) == (12.0, 0.0)

    def test_numbers_that_are_written_in_two_ways_are_two_objects(self):
        seen = [detection(name, 10.0 * place, 0.0) for place, name in enumerate(("7", "07", "0", "\u0667", "9" * 5000))]
        objects = watch(seen, seen)
        assert len({*objects.id.tolist()}) == 5
        assert objects.id.tolist()[::2][:2] == [7, 0]

    def test_who_was_gone_for_long_is_new(self):
        reader = Detections()
        for time, x, count in ((0.0, 0.0, 0), (0.1, 0.5, 1), (1.2, 40.0, 0), (1.3, 40.0, 1)):
            objects, _ = reader.read(detections(time, detection("7", x, 0.0)), pose_at(time))
            assert len(objects) == count
        assert objects.speed[0] == pytest.approx(0.0)

    def test_a_clock_set_back_forgets_all(self):
        reader = Detections()
        for time in (5.0, 5.1, 1.0):
            objects, _ = reader.read(detections(time, detection("7", 0.0, 0.0)), pose_at(time))
        assert len(objects) == 0

    @pytest.mark.parametrize("late", [0.02, 0.15, 0.9])
    def test_a_list_of_a_moment_before_leaves_nobody_out(self, late):
        reader = Detections()
        for step in range(1, 30):
            time = 5.0 + 0.1 * step - (late if step % 3 == 2 else 0.0)
            objects, _ = reader.read(detections(time, detection("7", 5.0 * time, 0.0)), pose_at(time))
            if step > 1:
                assert objects.x.tolist() == [5.0 * time]
            if step > 3:
                assert objects.speed[0] == pytest.approx(5.0)

    def test_a_clock_that_is_set_back_a_little_makes_nobody_fast(self):
        reader = Detections()
        for step in range(20):
            time, told = 0.1 * step, 5.0 + 0.1 * step - (0.8 if step >= 5 else 0.0)
            objects, _ = reader.read(detections(told, detection("7", 5.0 * time, 0.0)), pose_at(told))
            if step:
                assert objects.speed[0] == pytest.approx(5.0)

    def test_the_same_stamp_twice_changes_nothing(self):
        reader = Detections()
        for time, x in ((0.0, 0.0), (0.1, 0.5), (0.1, 0.9)):
            objects, _ = reader.read(detections(time, detection("7", x, 0.0)), pose_at(time))
        assert objects.speed[0] == pytest.approx(5.0)

    def test_who_is_seen_again_while_no_time_passes_stands(self):
        reader = Detections()
        for x in (30.0, 29.0):
            objects, _ = reader.read(detections(7.0, detection("7", x, 0.0)), pose_at(7.0))
        assert (objects.x.tolist(), objects.speed.tolist()) == ([29.0], [0.0])

    def test_without_a_stamp_the_list_is_of_the_moment_of_the_odometry(self):
        reader = Detections()
        for time, x in ((5.0, 0.0), (5.1, 0.5), (5.2, 1.0)):
            objects, _ = reader.read(detections(0.0, detection("7", x, 0.0)), pose_at(time))
        assert objects.speed[0] == pytest.approx(5.0)

    @pytest.mark.parametrize("broken", [0, 2])
    def test_a_place_that_is_no_number_is_told_and_spoils_nothing_that_comes_later(self, broken):
        reader = Detections()
        for step in range(6):
            x = math.nan if step == broken else 0.5 * step
            objects, _ = reader.read(detections(0.1 * step, detection("7", x, 0.0)), pose_at(0.1 * step))
            if step == broken:
                assert np.isnan(objects.x).tolist() == [True]
        assert objects.speed[0] == pytest.approx(5.0)

    def test_without_an_id_it_stands_and_counts_at_once(self):
        objects = watch([detection("", 30.0, 1.0), detection("", 40.0, 1.0)])
        assert objects.speed.tolist() == [0.0, 0.0]
        assert len(set(objects.id.tolist())) == 2

    def test_names_become_numbers_that_stay(self):
        reader = Detections()
        both = [detection("left car", 0.0, 5.0), detection("right car", 0.0, -5.0)]
        first = watch(both, both, reader=reader)
        again, _ = reader.read(detections(0.2, *reversed(both)), pose_at(0.2))
        assert dict(zip(first.id, first.y, strict=True)) == dict(zip(again.id, again.y, strict=True))
        assert min(first.id) >= 1 << 31

    def test_noise_is_smoothed(self):
        noise = np.random.default_rng(1).normal(0.0, 0.05, 40)
        objects = watch(*([detection("7", 0.5 * step + shift, 0.0)] for step, shift in enumerate(noise)))
        assert objects.speed[0] == pytest.approx(5.0, abs=0.6)

    @pytest.mark.parametrize(("yaw", "turned"), [(math.pi, False), (0.5 * math.pi, True), (-0.4, False)])
    def test_the_axis_nearest_to_the_motion_is_the_heading(self, yaw, turned):
        objects = watch(*moving(speed=8.0, toward=0.0, yaw=yaw))
        assert abs(objects.yaw[0]) <= 0.25 * math.pi
        assert objects.speed[0] == pytest.approx(8.0 * math.cos(objects.yaw[0]))
        assert bool(objects.length[0] < objects.width[0]) is turned

    def test_of_a_square_box_the_motion_is_the_heading(self):
        walk = moving(speed=1.5, toward=1.0, yaw=0.0, length=0.6, width=0.6, kinds=[("person", 0.8)])
        objects = watch(*walk)
        assert (objects.yaw[0], objects.speed[0]) == pytest.approx((1.0, 1.5))
        assert objects.kind[0] == ObjectKind.PEDESTRIAN

    def test_who_stands_keeps_the_heading_of_the_box(self):
        assert watch(*moving(speed=0.0, yaw=2.0)).yaw[0] == pytest.approx(2.0)

    def test_in_the_ego_frame_they_are_placed_where_the_ego_is(self):
        x, y, yaw = 100.0, 50.0, 0.5 * math.pi
        still = [detection("7", 20.0, 3.0, 0.2)]
        objects = watch(still, still, frame="base_link", x=x, y=y, yaw=yaw, speed=0.0)
        assert (objects.x[0], objects.y[0]) == pytest.approx((97.0, 70.0))
        assert objects.yaw[0] == pytest.approx(yaw + 0.2)

    def test_seen_from_a_moving_ego_who_stands_stands_though_odometry_is_older(self):
        reader = Detections()
        for step in range(1, 20):
            seen, told = 0.1 * step, 0.1 * step - 0.01 * (step % 3)  # the odometry is up to 20 ms older
            message = detections(seen, detection("7", 60.0 - 12.0 * seen, 0.0), frame="base_link")
            objects, _ = reader.read(message, pose_at(told, x=12.0 * told, speed=12.0))
        assert objects.speed[0] == pytest.approx(0.0, abs=1e-6)
        assert objects.x[0] == pytest.approx(60.0)

    def test_another_frame_is_refused_by_name(self):
        with pytest.raises(ValueError, match="frame 'camera', not in odom or base_link"):
            Detections().read(detections(0.0, frame="camera"), pose_at())

    @pytest.mark.parametrize(
        ("kinds", "kind"),
        [
            ([("vehicle.truck", 0.5)], ObjectKind.TRUCK),
            ([("Pedestrian", 0.2), ("car", 0.7)], ObjectKind.CAR),
            ([("17", 0.9)], ObjectKind.UNKNOWN),
            ([], ObjectKind.UNKNOWN),
        ],
    )
    def test_kinds_by_name(self, kinds, kind):
        assert watch(*moving(kinds=kinds)).kind[0] == kind

    def test_a_box_without_a_heading_is_left_to_the_guard(self):
        box = detection("7", 0.0, 0.0)
        box.bbox.center.orientation = QUATERNION(x=0.0, y=0.0, z=0.0, w=0.0)
        assert math.isnan(watch([box], [box]).yaw[0])

    def test_an_empty_list_is_a_list(self):
        assert len(watch([], [])) == 0


def test_own_objects_must_be_in_the_frame_of_the_odometry():
    message = OBJECTS(header=header(0.0, "map"))
    assert len(OwnObjects().read(message, pose_at(frame="map"))[0]) == 0
    with pytest.raises(ValueError, match="frame 'map', not in odom"):
        OwnObjects().read(message, pose_at())
