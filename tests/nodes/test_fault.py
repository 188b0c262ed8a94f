"""Why a node ended, from its process to the launcher."""

import pytest

from roadmend.core.errors import InputError, RoadmendError, SimulationError
from roadmend.nodes.fault import FAULT_FILE, leave_fault, read_fault


@pytest.mark.parametrize(
    ("error", "kind", "words"),
    [
        (InputError("a: b", "c; d", "e"), InputError, "a: b: c; d; e"),
        (SimulationError("SUMO failed"), RoadmendError, "SUMO failed"),
        (ValueError("one\n two"), RoadmendError, "ValueError: one two"),
    ],
)
def test_what_is_left_is_read(tmp_path, monkeypatch, error, kind, words):
    monkeypatch.setenv(FAULT_FILE, str(tmp_path / "fault"))
    assert leave_fault(error)
    found = read_fault(tmp_path / "fault")
    assert (type(found), str(found)) == (kind, words)


def test_nothing_is_left_without_a_place_or_where_there_is_none(tmp_path, monkeypatch):
    monkeypatch.delenv(FAULT_FILE, raising=False)
    assert not leave_fault(ValueError())
    monkeypatch.setenv(FAULT_FILE, "/proc/none/fault")
    assert not leave_fault(ValueError())
    assert read_fault(tmp_path / "fault") is None
