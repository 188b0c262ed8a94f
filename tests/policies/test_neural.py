"""The neural policy: contract of a policy, on the shipped model."""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.core.outcome import EventKind
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.policies.neural import NeuralPolicy, action_of
from roadmend.policies.neural_kinds import KINDS
from roadmend.policies.registry import make_policy
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.runner import run_episode

from .proving_ground import Body, drive, road, scene_at, two_lanes
from .test_completion import Unrepaired

BINS = KINDS["neural"].bins
ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def policy() -> NeuralPolicy:
    return make_policy("neural")


def test_drives_on_a_free_road(policy):
    run = drive(policy, road(), 15.0, 5.0, 3.0)
    assert 11.0 < run.speed[-1] < 15.5


def test_stops_behind_a_standing_vehicle(policy):
    run = drive(policy, road(), 25.0, 5.0, 12.0, [Body(1, 150.0, 0.0)])
    assert run.gap > 0.2


def test_plans_begin_at_the_ego(policy):
    run = drive(policy, two_lanes(), 6.0, 5.0, 15.0)
    for decision, x, speed in zip(run.decisions[1:], run.x, run.speed, strict=False):
        plan = decision.trajectory
        assert len(plan) > 4
        assert abs(plan.x[0] - x - speed * plan.interval) < 0.8


def test_the_same_scenes_give_the_same_bits_after_a_reset(policy):
    others = [Body(number, 60.0 * number - 40.0, 3.2, 0.0, 18.0) for number in range(5)]
    first = drive(policy, two_lanes(), 6.0, 5.0, 15.0, others)
    drive(policy, road(), 2.0, 5.0, 3.0)
    second = drive(make_policy("neural"), two_lanes(), 6.0, 5.0, 15.0, others)
    assert first.x == second.x
    assert [a.command for a in first.decisions] == [b.command for b in second.decisions]


def test_brakes_where_its_own_state_is_unusable(policy):
    policy.reset(road())
    assert policy.step(scene_at(0.0, math.nan, 5.0)).command.brake > 0.0


def test_the_action_is_a_mean_around_the_most_probable_bin():
    logits = np.full(BINS, -30.0, dtype=np.float32)
    logits[5] = 10.0
    assert action_of(logits) == pytest.approx(-0.5)
    logits[6] = 10.0
    assert action_of(logits) == pytest.approx(-0.45)
    for place in range(BINS):
        assert -1.0 <= action_of(np.eye(BINS, dtype=np.float32)[place] * 50.0) <= 1.0


def test_completes_most_of_a_small_sample(policy):
    outcomes = [
        run_episode(sample_scenario(family, seed), policy, Unrepaired()).outcome
        for family in FAMILIES
        for seed in range(61_000, 61_003)
    ]
    assert outcomes.count(EventKind.GOAL) >= 0.6 * len(outcomes)


def test_a_model_that_is_missing_or_of_another_kind_is_refused(tmp_path):
    with pytest.raises(InputError, match="nobody"):
        make_policy("neural", {"model": "nobody"})
    damaged = tmp_path / "model.safetensors"
    damaged.write_bytes(b"x" * 100)
    with pytest.raises(InputError, match="model"):
        make_policy("neural", {"model": str(damaged)})


def test_the_shipped_model_says_how_it_was_made():
    header = load_checkpoint(find_model("neural"), "neural").header
    assert header["configuration"]["command"].startswith("./roadmend train policy")
    assert header["configuration"]["training"]["first_seed"] >= 50_000
    assert header["metrics"]["scenes"] > 10_000


def test_driving_imports_no_torch():
    code = (
        "import sys; from roadmend.policies.registry import make_policy; make_policy('neural');"
        "import json; print(json.dumps(sorted(n for n in sys.modules if n.split('.')[0] in ('torch', 'tensorboard'))))"
    )
    done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, cwd=ROOT)
    assert json.loads(done.stdout) == []
