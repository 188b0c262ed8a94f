"""Driving under a repair method: as the runner has it, and told in info."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from roadmend import InputError, Proposal, run, sample_scenario
from roadmend.gym import DriveEnv, RepairWrapper
from tests.gym.push import Push

PUSH = np.array([0.6], dtype=np.float32)


class Always:
    """Brakes at every tick."""

    name = "always"

    def reset(self, route):
        pass

    def propose(self, scene, decision):
        return Proposal(1.0, 0.5, -0.25, reason="always")


def drive(env):
    env.reset()
    infos, rewards, over = [], [], False
    while not over:
        _, reward, terminated, truncated, info = env.step(PUSH)
        over = terminated or truncated
        infos.append(info)
        rewards.append(reward)
    env.close()
    return infos, rewards


@pytest.mark.parametrize(("method", "number"), [("rss", 0), ("random", 0), ("adreft", 21)])
def test_it_drives_as_the_runner_does(method, number):
    scenario = sample_scenario("S3", number)
    told = run(scenario, Push(PUSH[0]), method, seed=3).figures()
    infos, _ = drive(RepairWrapper(DriveEnv(scenario), method, seed=3))
    assert infos[-1]["result"] == {**told, "policy": "learner"}
    assert sum(info["repair"]["intervened"] for info in infos) == told["interventions"] > 0


def test_a_method_of_ones_own_and_the_price_of_a_change():
    scenario = sample_scenario("S3", 3).model_copy(update={"time_limit": 0.5})
    infos, rewards = drive(RepairWrapper(DriveEnv(scenario), Always, price=-2.0))
    for info, reward in zip(infos, rewards, strict=True):
        told = info["repair"]
        assert told["intervened"]
        assert (told["policy_action"], told["final_action"]) == (pytest.approx(0.6), -0.25)
        assert info["reward_terms"]["repair"] == pytest.approx(-2.0 * 0.85)
        assert reward == pytest.approx(sum(info["reward_terms"].values()))
    assert infos[-1]["result"]["method"].endswith(":Always")


def test_the_learners_action_is_still_held_against_the_action_space():
    env = RepairWrapper(DriveEnv(sample_scenario("S3", 3)), "rss")
    env.reset()
    with pytest.raises(InputError, match="is no action; give one number"):
        env.step(np.array([0.3, -1.0]))
    env.close()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*is different from the unwrapped version")  # it is the wrapper that is checked
def test_gymnasium_finds_nothing_wrong():
    env = RepairWrapper(gymnasium.make("roadmend/Drive-v0", families=["S3"], count=1), "rss")
    check_env(env, skip_render_check=True)
    env.close()


def test_what_cannot_be_repaired_is_refused():
    env = DriveEnv(families=["S3"], count=1)
    with pytest.raises(InputError, match="there is no 'rsss', did you mean rss"):
        RepairWrapper(env, "rsss")
    with pytest.raises(InputError, match=r"price: is 1\.0; give 0 or less"):
        RepairWrapper(env, "rss", price=1.0)
    for price in ("a", float("-inf"), float("nan")):
        with pytest.raises(InputError, match=r"price: is .*; give 0 or less"):
            RepairWrapper(env, "rss", price=price)
    with pytest.raises(InputError, match="there is one already around this environment; wrap it once"):
        RepairWrapper(gymnasium.wrappers.TimeLimit(RepairWrapper(env), 100), "random")
    with pytest.raises(InputError, match="has no method propose"):
        RepairWrapper(env, Push)
    with pytest.raises(InputError, match="wrap roadmend/Drive-v0"):
        RepairWrapper(gymnasium.make("CartPole-v1"), "rss")
