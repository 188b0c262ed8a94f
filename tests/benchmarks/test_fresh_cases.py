"""Cases that a benchmark gathers for itself."""

import io
from types import SimpleNamespace

from rich.console import Console
from rich.progress import Progress

from harness import fresh_cases as module
from harness.fresh_cases import fresh_cases


def test_the_search_is_asked_and_what_is_missing_is_told(tmp_path, monkeypatch):
    asked, said = [], io.StringIO()

    def gather(policy, seed, cases, folder, workers, report, *, families):
        asked.append((policy, seed, cases, folder, workers, families))
        report(SimpleNamespace(stage="avfuzzer", done=2, total=9, accepted=1, wanted=6))
        return SimpleNamespace(corpus="fresh", shortages=["S1: one is missing"])

    monkeypatch.setattr(module, "gather_fresh", gather)
    with Progress(console=Console(file=said)) as progress:
        assert fresh_cases("modular", 7, 3, tmp_path, 1, progress, ("S1",)) == "fresh"
        (task,) = progress.tasks
    assert asked == [("modular", 7, 3, tmp_path / "fresh", 1, ("S1",))]
    assert "modular: S1: one is missing" in said.getvalue()
    assert task.description == "modular: avfuzzer 2/9, 1 of 6 fresh cases"
    assert (task.completed, task.total) == (1, 6)
