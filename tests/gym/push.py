"""A policy that does what the tests' learners do."""

from roadmend import Command, Decision, Trajectory


class Push:
    """Pushes evenly, whoever is ahead."""

    name = "push"

    def __init__(self, action):
        self.action = float(action)

    def reset(self, route):
        pass

    def step(self, scene):
        return Decision(Command.from_action(self.action, change_lane=True), Trajectory.empty())
