"""Cases for the tests of training: random draws in place of a corpus."""

from dataclasses import dataclass

from roadmend.world.families import sample_scenario


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
