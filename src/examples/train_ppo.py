"""PPO of Stable-Baselines3 learns to drive under a repair method, in worker processes; then it is measured.

./roadmend set-up rl && .venv/bin/python src/examples/train_ppo.py
"""

import sys

from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.vec_env import SubprocVecEnv, VecNormalize

from roadmend import evaluate, sample_scenario
from roadmend.gym import DriveEnv, LearnedPolicy, RepairWrapper


def make(repair: str = "rss") -> RepairWrapper:
    """One environment, in whatever process; a change of the action by 1 costs 0.1."""
    return RepairWrapper(DriveEnv(families=["S3"], count=20), repair, price=-0.1)


def main(steps: int = 200_000, workers: int = 2, held_out: int = 10, limit: int = 60) -> None:
    """Learn for some steps and keep the network; then drive scenarios that were not seen, each up to a limit [s]."""
    bare = make_vec_env(make, workers, seed=0, vec_env_cls=SubprocVecEnv, vec_env_kwargs={"start_method": "spawn"})
    env = VecNormalize(bare, norm_obs_keys=["ego", "road", "zones", "objects"])  # the units differ
    try:
        model = PPO("MultiInputPolicy", env, n_steps=min(1024, steps // workers), seed=0, verbose=1)
        model.learn(steps)
        model.save("ppo.zip")
    finally:
        env.close()
    learned = LearnedPolicy(lambda seen: model.predict(env.normalize_obs(seen), deterministic=True)[0])
    unseen = [sample_scenario("S3", 100 + number) for number in range(held_out)]
    print(evaluate([each.model_copy(update={"time_limit": float(limit)}) for each in unseen], learned, "rss"))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:5]))
