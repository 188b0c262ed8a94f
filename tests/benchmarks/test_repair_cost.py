"""The cost of repairing one frame: on what it is measured, and that it is the methods' own time."""

import gc
import time

import numpy as np
import pytest

from harness.repair_cost import gather_moments, measure_cost
from roadmend.core.repair import Proposal
from roadmend.repair.none import NoRepair
from roadmend.repair.registry import make_repairer
from roadmend.world.families import FAMILIES


@pytest.fixture(scope="module")
def moments():
    return gather_moments(ticks=30)


class Sleeper:
    """Takes its time."""

    name = "sleeper"

    def __init__(self, seconds):
        self.seconds = seconds
        self.routes = []
        self.stamps = []

    def reset(self, route):
        self.routes.append(route)

    def propose(self, scene, decision):
        self.stamps.append(scene.time)
        assert not gc.isenabled() or len(self.stamps) <= 21  # the warm-up's and the untimed frames
        time.sleep(self.seconds)
        return Proposal(0.0, 1.0, 0.0)


class Broken(NoRepair):
    def propose(self, scene, decision):
        if scene.time > 0.5:
            raise ArithmeticError("no idea")
        return super().propose(scene, decision)


def test_every_frame_has_the_wanted_number_of_distinct_participants(moments):
    assert len({id(moment.route) for moment in moments}) == len(FAMILIES)
    for moment in moments:
        found = moment.scene.objects
        assert len(found) == len(set(found.id.tolist())) == 20
        assert np.isfinite(found.x + found.y + found.yaw + found.speed).all()


def test_too_many_are_cut_to_the_nearest():
    for moment in gather_moments(objects=2, ticks=3):
        assert len(moment.scene.objects) == 2


def test_the_frames_of_a_seed_are_always_the_same(moments):
    again = gather_moments(ticks=30)
    assert [moment.scene.objects.x.tobytes() for moment in again] == [m.scene.objects.x.tobytes() for m in moments]


def test_what_is_timed_is_the_method(moments):
    short, long = Sleeper(0.0005), Sleeper(0.002)
    found = measure_cost({"short": lambda: short, "long": lambda: long}, moments[:40], rounds=2, reference="long")
    assert 0.5 <= found["short"]["median_ms"] < found["long"]["median_ms"]
    assert found["long"]["median_ms"] >= 2.0
    assert all(figures["median_ms"] <= figures["p99_ms"] for figures in found.values())
    assert all(figures["cpu_median_ms"] <= figures["cpu_p99_ms"] for figures in found.values())
    assert found["long"]["cpu_median_ms"] < 1.0  # it slept
    assert found["long"]["ratio"] == 1.0
    assert found["short"]["ratio"] < 1.0
    assert short.stamps == long.stamps
    assert gc.isenabled()


def test_a_method_that_fails_is_not_timed_by_what_the_guard_does_instead(moments):
    with pytest.raises(RuntimeError, match="broken failed on frame"):
        measure_cost({"none": NoRepair, "broken": Broken}, moments)
    assert gc.isenabled()


def test_guarded_methods_are_taken_as_they_are(moments):
    found = measure_cost({name: lambda name=name: make_repairer(name) for name in ("none", "rss")}, moments, rounds=1)
    assert 0.0 < found["none"]["median_ms"] < found["rss"]["median_ms"]


def test_nothing_to_measure_on_is_an_error():
    with pytest.raises(ValueError, match="no moments"):
        measure_cost({"none": NoRepair}, [])
