"""PPO of Stable-Baselines3 learns to drive, under a repair method, in several worker processes.

./roadmend set-up rl && .venv/bin/python src/examples/train_ppo.py
"""

import sys

from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv, VecNormalize

from roadmend.gym import DriveEnv, RepairWrapper


def make(repair: str = "rss") -> RepairWrapper:
    """One environment, in whatever process; a change of the action by 1 costs 0.1."""
    return RepairWrapper(DriveEnv(families=["S3", "S4"], count=50), repair, price=-0.1)


def main(steps: int = 200_000, workers: int = 2, file: str = "ppo.zip") -> float:
    """Learn for some steps, and keep the network; returns the mean reward of the last episodes."""
    bare = make_vec_env(make, workers, seed=0, vec_env_cls=SubprocVecEnv, vec_env_kwargs={"start_method": "spawn"})
    with_scales = VecNormalize(bare, norm_obs_keys=["ego", "road", "zones", "objects"])
    try:
        model = PPO("MultiInputPolicy", with_scales, n_steps=min(1024, steps // workers), seed=0, verbose=1)
        model.learn(steps)
        model.save(file)
        with_scales.save(f"{file}.scales")
        return sum(each["r"] for each in model.ep_info_buffer) / max(1, len(model.ep_info_buffer))
    finally:
        with_scales.close()


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]))
