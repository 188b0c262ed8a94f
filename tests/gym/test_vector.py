"""Environments in worker processes: the same episodes as in this one."""

import gymnasium
import numpy as np
import pytest

import roadmend.gym  # noqa: F401 - makes the environment known
from roadmend import InputError
from roadmend.gym import DriveEnv, RepairWrapper, make_vector

SETTINGS = {"families": ["S3"], "count": 3}


@pytest.mark.slow
def test_each_worker_drives_what_one_alone_drives_with_its_seed():
    push = np.full((2, 1), 0.4, dtype=np.float32)
    vector = gymnasium.make_vec("roadmend/Drive-v0", num_envs=2, **SETTINGS)
    try:
        observations, infos = vector.reset(seed=4)
        assert observations["objects"].shape == (2, 16, 15)
        shown = [observations["ego"]]
        rewards = []
        for _ in range(30):
            observations, reward, *_ = vector.step(push)
            shown.append(observations["ego"])
            rewards.append(reward)
    finally:
        vector.close()
    for place, seed in enumerate((4, 5)):
        env = DriveEnv(**SETTINGS)
        observation, info = env.reset(seed=seed)
        assert info["scenario"] == infos["scenario"][place]
        assert np.array_equal(observation["ego"], shown[0][place])
        for number in range(30):
            observation, reward, *_ = env.step(push[place])
            assert np.array_equal(observation["ego"], shown[number + 1][place])
            assert reward == rewards[number][place]
        env.close()  # SUMO is the next one's


@pytest.mark.slow
def test_under_repair_info_tells_of_it():
    vector = make_vector(1, repair="rss", **SETTINGS)
    try:
        vector.reset(seed=4)
        info = vector.step(np.zeros((1, 1), dtype=np.float32))[-1]
        assert info["repair"]["status"][0] in {"PASS", "RESET", "REPAIRED"}
    finally:
        vector.close()


@pytest.mark.slow
def test_the_price_and_the_parameters_of_repair_reach_the_workers():
    repair = {"repair": "random", "parameters": {"probability": 1.0}, "seed": 3, "price": -0.1}
    vector = gymnasium.make_vec("roadmend/Drive-v0", num_envs=1, **repair, **SETTINGS)
    try:
        vector.reset(seed=4)
        infos = [vector.step(np.full((1, 1), 0.4, dtype=np.float32))[-1] for _ in range(5)]
    finally:
        vector.close()
    alone = RepairWrapper(DriveEnv(**SETTINGS), **repair)
    alone.reset(seed=4)
    for info in infos:
        told = alone.step(np.full(1, 0.4, dtype=np.float32))[-1]
        assert info["reward_terms"]["repair"][0] == told["reward_terms"]["repair"]
        assert info["repair"]["final_action"][0] == told["repair"]["final_action"]
    assert any(info["reward_terms"]["repair"][0] < 0.0 for info in infos)
    alone.close()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*(Received the following error|Raising the last exception|Traceback)")
def test_what_a_worker_refuses_is_refused_in_one_line():
    vector = make_vector(1, **SETTINGS)
    try:
        vector.reset(seed=4)
        with pytest.raises(InputError, match=r"is no action; give one number") as caught:
            vector.step(np.full((1, 1), 1.5, dtype=np.float32))
        assert "\n" not in str(caught.value)
    finally:
        vector.close(terminate=True)


def test_what_cannot_be_meant_is_refused():
    with pytest.raises(InputError, match="num_envs: 0 is no whole number from 1"):
        make_vector(0)
    with pytest.raises(InputError, match="num_envs: '2' is no whole number from 1"):
        make_vector("2")
    for given in ({"price": -0.1}, {"parameters": {"rho": 0.5}}, {"seed": 1}):
        with pytest.raises(InputError, match="none that repairs; give one"):
            make_vector(1, **given)
    with pytest.raises(InputError, match="price: is 1"):
        make_vector(1, repair="rss", price=1.0, **SETTINGS)
