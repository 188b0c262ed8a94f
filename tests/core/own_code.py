"""Code as a user might have it, for the fixture ``own``."""

POLICY = """
from roadmend.core.command import Command, Decision, Trajectory

class Careful:
    name = "careful"
    def reset(self, route):
        self.ticks = 0
    def step(self, scene):
        self.ticks += 1
        return Decision(Command.from_action(min(0.5 * (8.0 - scene.ego.speed), 0.5)), Trajectory.empty())

class Late(Careful):
    def step(self, scene):
        if scene.time > 1.0:
            return 1 / 0
        return super().step(scene)

class Never(Careful):
    def step(self, scene):
        return None
"""
METHOD = """
from pydantic import Field
from roadmend.core.parameters import Parameters
from roadmend.core.repair import Proposal

class Settings(Parameters):
    distance: float = Field(8.0, ge=0.0, le=50.0, description="[m]")

class Near:
    name = "near"
    def __init__(self, parameters: Settings, seed: int = 0):
        self.parameters, self.seed = parameters, seed
    def reset(self, route):
        pass
    def propose(self, scene, decision):
        nearest = min(((scene.objects.x - scene.ego.x) ** 2 + (scene.objects.y - scene.ego.y) ** 2) ** 0.5, default=999.0)
        return Proposal(self.parameters.distance - nearest, 0.0, -0.8)

class Late(Near):
    def propose(self, scene, decision):
        if scene.time > 1.0:
            raise KeyError("lost")
        return super().propose(scene, decision)

class Never(Near):
    def propose(self, scene, decision):
        return 0.5
"""
