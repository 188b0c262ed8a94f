"""What is changed, and who must notice."""

from dataclasses import dataclass
from pathlib import Path

SOURCE = Path(__file__).parents[2] / "src" / "roadmend"
BAR = 0.95  # share of all mutants together that the tests must kill


@dataclass(frozen=True)
class Target:
    """A file and the tests that must notice."""

    file: str
    tests: tuple[str, ...]
    functions: tuple[str, ...] = ()  # only these; all if empty
    left_out: tuple[str, ...] = ()

    @property
    def path(self) -> Path:
        return SOURCE / self.file

    @property
    def module(self) -> str:
        return "roadmend." + self.file.removesuffix(".py").replace("/", ".")


TARGETS = (
    Target("world/ego.py", ("world/test_ego.py",)),
    Target("world/blame.py", ("world/test_blame.py",)),
    Target("world/simulation.py", ("world/test_verdict.py",), ("_observe", "_hit", "_clear")),
    Target("repair/guard.py", ("repair/test_guard.py",), left_out=("warm_up",)),  # any scene will do there
    Target("repair/merger.py", ("repair/test_merger.py",)),
    Target("repair/sanitise.py", ("repair/test_sanitise.py",)),
)
