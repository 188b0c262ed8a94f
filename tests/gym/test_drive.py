"""roadmend/Drive-v0: what the checkers say, and that it drives as the runner does."""

import math

import gymnasium
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env as gymnasium_check
from stable_baselines3.common.env_checker import check_env as stable_baselines_check

import roadmend.gym
from roadmend import InputError, SimulationError, run, sample_scenario
from roadmend.gym import DriveEnv, LearnedPolicy, RewardWeights
from roadmend.world.obstacle import Obstacle
from roadmend.world.scenario_file import save_scenario
from roadmend.world.simulation import Simulation
from tests.gym.push import Push

PUSH = np.array([0.4], dtype=np.float32)


@pytest.fixture
def make():
    """Environments that are closed in the end."""
    made = []

    def one(**settings):
        made.append(DriveEnv(**settings))
        return made[-1]

    yield one
    for env in made:
        env.close()


def drive(env, action=PUSH, **reset):
    """An episode to its end: the observations, the rewards and the infos, that of the reset first."""
    observation, info = env.reset(**reset)
    observations, rewards, infos = [observation], [], [info]
    over = False
    while not over:
        observation, reward, terminated, truncated, info = env.step(action)
        over = terminated or truncated
        observations.append(observation)
        rewards.append(reward)
        infos.append(info)
    return observations, rewards, infos


@pytest.mark.slow
def test_gymnasium_finds_nothing_wrong():
    made = gymnasium.make("roadmend/Drive-v0", families=["S3"], count=1)
    gymnasium_check(made.unwrapped)
    made.close()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Your observation .* has an unconventional shape")  # rows of objects
def test_stable_baselines_finds_nothing_wrong(make):
    for settings in ({"families": ["S3"]}, {"families": ["S4"], "lane_change": True, "objects": 3}):
        env = make(count=1, **settings)
        stable_baselines_check(env)
        env.close()


def test_it_is_known_in_its_namespace_and_only_once():
    roadmend.gym.register()
    spec = gymnasium.spec("roadmend/Drive-v0")
    assert (spec.namespace, spec.name, spec.version) == ("roadmend", "Drive", 0)


def test_what_is_driven_is_what_the_runner_drives(make):
    scenario = sample_scenario("S4", 5)
    told = run(scenario, Push(PUSH[0]), "none").figures()
    _, _, infos = drive(make(scenarios=scenario))
    result = infos[-1]["result"]
    assert {**told, "policy": "learner"} == result
    assert infos[-1]["outcome"] == told["outcome"]
    assert infos[-1]["tick"] == told["ticks"]
    assert [event["kind"] for event in infos[0]["events"]] == ["STARTED"]
    assert infos[-1]["events"][-1]["kind"] == told["outcome"]


def test_a_seed_is_an_episode_whatever_was_driven_before(make):
    env = make(families=["S3", "S5"], count=3)
    first = drive(env, seed=4)
    drive(env, seed=5)
    again = drive(env, seed=4)
    assert first[2][-1]["result"] == again[2][-1]["result"]
    assert first[1] == again[1]
    for one, other in zip(first[0], again[0], strict=True):
        assert all(np.array_equal(one[name], other[name]) for name in one)
    names = {env.reset(seed=seed)[1]["scenario"] for seed in range(12)}
    assert len(names) > 1
    assert names <= {f"{family}-{number}" for family in ("S3", "S5") for number in range(3)}


def test_a_policy_of_what_was_learned_sees_what_the_environment_showed(make):
    scenario = sample_scenario("S3", 3)

    def act(seen):
        return np.clip(0.5 * (8.0 - seen["ego"][:1]), -1.0, 1.0)

    seen = []
    learned = LearnedPolicy(lambda observation: (seen.append(observation), act(observation))[1])
    result = run(scenario, learned, "none")
    env = make(scenarios=scenario)
    observation, _ = env.reset()
    over, shown = False, []
    while not over:
        shown.append(observation)
        observation, _, terminated, truncated, info = env.step(act(observation))
        over = terminated or truncated
    assert info["result"]["digest"] == result.digest
    driven = seen[-len(shown) :]  # before, it was asked about a plain scene
    assert all(np.array_equal(one[name], other[name]) for one, other in zip(driven, shown, strict=True) for name in one)


def test_the_reward_is_the_sum_of_its_terms_and_a_weight_counts(make):
    scenario = sample_scenario("S3", 1)
    _, rewards, infos = drive(make(scenarios=scenario))
    for reward, info in zip(rewards, infos[1:], strict=True):
        assert set(info["reward_terms"]) == set(RewardWeights.model_fields)
        assert reward == pytest.approx(sum(info["reward_terms"].values()))
    assert infos[-1]["outcome"] == "GOAL"
    assert infos[-1]["reward_terms"]["goal"] == 10.0
    metres = sum(info["reward_terms"]["progress"] for info in infos[1:]) / RewardWeights().progress
    assert metres == pytest.approx(run(scenario, Push(PUSH[0]), "none").distance, rel=0.01)
    alone = dict.fromkeys(RewardWeights.model_fields, 0.0) | {"goal": 3.0}
    _, rewards, _ = drive(make(scenarios=scenario, reward=alone))
    assert sum(rewards) == 3.0


def test_a_collision_terminates_and_the_time_limit_truncates(make):
    scenario = sample_scenario("S3", 3).model_copy(update={"time_limit": 0.5})
    env = make(scenarios=scenario)
    env.reset()
    ends = [env.step(np.array([-1.0]))[2:4] for _ in range(10)]
    assert ends == [(False, False)] * 9 + [(False, True)]
    full = np.array([1.0])
    for number in range(3, 40):
        _, _, infos = drive(env, full, options={"scenario": sample_scenario("S3", number)})
        if infos[-1]["outcome"] == "COLLISION":
            break
    (event,) = [event for event in infos[-1]["events"] if event["kind"] == "COLLISION"]
    assert infos[-1]["reward_terms"]["collision"] == -10.0
    assert (infos[-1]["reward_terms"]["fault"] == -10.0) is event["at_fault"]
    assert event["impact_speed"] > 0.0


def test_the_learner_may_say_when_to_change_lanes(make):
    scenario = sample_scenario("S4", 5)

    def changes(action, **settings):
        _, _, infos = drive(make(scenarios=scenario, **settings), np.array(action))
        return [event["time"] for info in infos for event in info["events"] if event["kind"] == "CHANGE_LANE"]

    assert changes([0.4]) == changes([0.4, 1.0], lane_change=True) != []
    assert changes([0.4, -1.0], lane_change=True) == []


def test_two_in_a_process_take_turns_and_are_refused_in_between(make):
    one, other = make(families=["S3"], count=1), make(families=["S3"], count=1)
    one.reset(seed=1)
    with pytest.raises(SimulationError, match="another episode is under way in this process") as caught:
        other.reset(seed=1)
    assert "\n" not in str(caught.value)
    with pytest.raises(SimulationError, match="another episode is under way"):
        run(sample_scenario("S3", 3))
    one.step(PUSH)  # nothing was taken from it
    one.close()
    other.reset(seed=1)
    one.close()  # nor does it take anything
    drive_on = [other.step(PUSH) for _ in range(3)]
    assert len(drive_on) == 3
    other.close()
    drive(one, seed=1)
    drive(other, seed=1)  # the first one's episode is over


def test_a_step_without_an_episode_is_refused(make):
    env = make(families=["S3"], count=1)
    with pytest.raises(ResetNeeded):
        env.step(PUSH)
    drive(env, seed=1)
    with pytest.raises(ResetNeeded):
        env.step(PUSH)


@pytest.mark.parametrize("action", [[math.nan], [1.01], [-1.5], [0.1, 0.2, 0.3], 0.3, [[0.3]], [0.3, math.inf]])
def test_what_is_no_action_is_refused(make, action):
    env = make(scenarios=sample_scenario("S3", 3))
    env.reset()
    with pytest.raises(InputError, match="is no action; give one number"):
        env.step(np.array(action))


@pytest.mark.parametrize("action", ["abc", ["x"], None, {"a": 1}, [[0.1], [0.2, 0.3]], [0.5 + 0.1j], [None]])
def test_what_is_no_number_is_no_action(make, action):
    env = make(scenarios=sample_scenario("S3", 3))
    env.reset()
    with pytest.raises(InputError, match="is no action; give one number"):
        env.step(action)


def test_the_last_scenarios_can_be_drawn(make):
    env = make(families=["S3"], first=2**31 - 1, count=1)
    assert env.reset(seed=1)[1]["scenario"] == "S3-2147483647"


@pytest.mark.parametrize(("lane_change", "action"), [(False, [0.3, -1.0]), (True, [0.3])])
def test_an_action_has_as_many_numbers_as_the_action_space(make, lane_change, action):
    env = make(scenarios=sample_scenario("S3", 3), lane_change=lane_change)
    env.reset()
    with pytest.raises(InputError, match=r"is no action; give (one|two) number"):
        env.step(np.array(action))


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"families": ["S33"]}, "there is no 'S33', did you mean S3"),
        ({"families": []}, "families: there is none"),
        ({"scenarios": []}, "scenarios: there is none"),
        ({"scenarios": "gone.yaml"}, "no such file"),
        ({"scenarios": sample_scenario("S3", 3), "families": ["S3"]}, "both scenarios and families"),
        ({"scenarios": sample_scenario("S3", 3), "first": 7}, "both scenarios and first"),
        ({"scenarios": sample_scenario("S3", 3), "count": 20}, "both scenarios and count"),
        ({"scenarios": 5}, "scenarios: is 5"),
        ({"families": "S3"}, "families: is 'S3'; give a list of names"),
        ({"families": 3}, "families: is 3; give a list of names"),
        ({"families": [3]}, "families: 3 is no name; choose of S1"),
        ({"first": 2**31 - 2, "count": 3}, "first: 2147483646 and count 3 go beyond the last"),
        ({"count": 10**30}, "go beyond the last scenario of a family; stay up to number 2147483647"),
        ({"lane_change": "no"}, "lane_change: is 'no'; give True or False"),
        ({"reward": 5}, "reward: is 5; give weights by name"),
        ({"reward": ["goal"]}, "reward: is ['goal']"),
        ({"count": 0}, "count: 0 is no whole number from 1; give for instance 7"),
        ({"objects": 2.5}, "objects: 2.5 is no whole number from 1"),
        ({"first": True}, "first: True is no whole number from 0"),
        ({"reward": {"gaol": 3.0}}, "did you mean goal"),
        ({"reward": {"goal": "much"}}, "reward.goal"),
    ],
)
def test_what_cannot_be_meant_is_refused(settings, said):
    with pytest.raises(InputError) as caught:
        DriveEnv(**settings)
    assert said in str(caught.value)


def test_options_of_a_reset(make, tmp_path):
    env = make(families=["S3"], count=1)
    save_scenario(sample_scenario("S3", 3), tmp_path / "s.yaml")
    assert env.reset(options={"scenario": str(tmp_path / "s.yaml")})[1]["scenario"] == "S3-3"
    with pytest.raises(InputError, match="'scenaro' is unknown"):
        env.reset(options={"scenaro": 3})


def test_where_sumo_fails_at_once_it_is_given_back(make, monkeypatch):
    env = make()
    with monkeypatch.context() as context:
        context.setattr(Simulation, "first", lambda _: (_ for _ in ()).throw(SimulationError("SUMO failed")))
        with pytest.raises(SimulationError):
            env.reset(seed=1)
    other = make()
    other.reset(seed=1)
    other.step(PUSH)


def test_a_scenario_whose_ego_stands_in_something_is_refused_by_reset_and_gives_sumo_back(make):
    scenario = sample_scenario("S3", 0).model_copy(update={"actors": []})
    env = make(scenarios=[scenario])
    env.reset()
    ego = env.tick.scene.ego
    wall = Obstacle(id="wall", x=ego.x, y=ego.y, length=2.0, width=2.0)
    blocked = scenario.model_copy(update={"obstacles": [wall]})
    with pytest.raises(InputError, match=r"is over before a step: .* collided"):
        env.reset(options={"scenario": blocked})
    with pytest.raises(ResetNeeded):
        env.step(PUSH)
    env.reset()
    env.step(PUSH)
