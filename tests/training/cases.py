"""Cases for the tests of training: random draws in place of a corpus."""

from dataclasses import dataclass
from pathlib import Path

from roadmend.world.families import sample_scenario
from roadmend.world.scenario_networks import NetworkFile


@dataclass(frozen=True)
class Drawn:
    """A case that is a random draw; its digest is not known beforehand."""

    family: str
    seed: int
    is_violation: bool = False
    digest: str = ""

    @property
    def name(self):
        return f"{self.family}-{self.seed}"

    def scenario(self):
        return sample_scenario(self.family, self.seed)


@dataclass(frozen=True)
class OnMap(Drawn):
    """The same on a map of one's own, which nobody can drive: a file that says what it is given."""

    path: Path = Path()

    def scenario(self):
        return super().scenario().model_copy(update={"network": NetworkFile(path=str(self.path))})
