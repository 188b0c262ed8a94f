"""Environments in worker processes: the same episodes as in this one."""

import gymnasium
import numpy as np
import pytest

import roadmend.gym  # noqa: F401 - makes the environment known
from roadmend import InputError
from roadmend.gym import DriveEnv, make_vector

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


def test_none_is_refused():
    with pytest.raises(InputError, match="num_envs: is 0"):
        make_vector(0)
