from roadmend.gym.drive import DriveEnv as DriveEnv
from roadmend.gym.observer import LearnedPolicy as LearnedPolicy
from roadmend.gym.registration import ENVIRONMENT as ENVIRONMENT
from roadmend.gym.registration import register as register
from roadmend.gym.repair import RepairWrapper as RepairWrapper
from roadmend.gym.reward import RewardWeights as RewardWeights
from roadmend.gym.vector import make_vector as make_vector
