"""Labels by hand-made cases."""

import math

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.repair.actions import ACTIONS
from roadmend.training.adreft.case_frames import CaseFrames
from roadmend.training.adreft.labels import make_scheme


def frames_of(outcome, end, time, distance):
    time, distance = np.array(time, dtype=np.float64), np.array(distance, dtype=np.float64)
    count = len(time)
    return CaseFrames(
        "hand-made",
        "S1",
        outcome,
        end,
        time,
        np.zeros(count, np.float32),
        distance,
        np.ones(count, np.int32),
        np.zeros((count, 6), np.float32),
    )


TIME = [0.0, 2.0, 4.0, 6.95, 7.0, 7.05, 9.9]
FAR = [50.0, 0.5, math.inf, 5.0, 5.0, 5.0, 1.0]


@pytest.mark.parametrize(
    ("scheme", "outcome", "critical"),
    [
        ("weak", "GOAL", [0, 1, 0, 0, 0, 0, 0]),
        ("weak", "TIMEOUT", [0, 1, 0, 0, 0, 0, 0]),
        ("weak", "COLLISION", [0, 1, 0, 0, 0, 1, 1]),  # strictly later than 3 s before the collision at 10 s
        ("weak_without_regulation", "GOAL", [0, 0, 0, 0, 0, 0, 0]),
        ("weak_without_regulation", "COLLISION", [0, 0, 0, 0, 0, 1, 1]),
    ],
)
def test_the_papers_weak_labels(scheme, outcome, critical):
    labels = make_scheme(scheme).label(None, frames_of(outcome, 10.0, TIME, FAR))
    assert labels.critical.tolist() == critical
    assert [ACTIONS[index] for index in labels.action] == [-1.0 if wanted else 0.8 for wanted in critical]
    assert labels.critical_weight.tolist() == labels.action_weight.tolist() == [1.0] * len(TIME)


def test_just_below_one_metre_is_near():
    labels = make_scheme("weak").label(None, frames_of("GOAL", 10.0, [1.0, 2.0], [0.999, 1.0]))
    assert labels.critical.tolist() == [1.0, 0.0]


def test_an_unknown_scheme_is_refused_with_the_known_ones():
    with pytest.raises(InputError, match=r"no 'strong'.*weak, weak_without_regulation"):
        make_scheme("strong")


def test_frames_come_back_from_disk_as_they_were(tmp_path):
    frames = frames_of("COLLISION", 10.0, TIME, FAR)
    frames.save(tmp_path / "sub" / "case.npz")
    again = CaseFrames.load(tmp_path / "sub" / "case.npz")
    assert (again.name, again.family, again.outcome, again.end) == ("hand-made", "S1", "COLLISION", 10.0)
    for name in ("time", "action", "distance", "counts", "tokens"):
        np.testing.assert_array_equal(getattr(again, name), getattr(frames, name))
        assert getattr(again, name).dtype == getattr(frames, name).dtype
    assert [path.name for path in (tmp_path / "sub").iterdir()] == ["case.npz"]


def test_a_cut_file_is_damaged(tmp_path):
    frames_of("GOAL", 1.0, [0.0], [1.0]).save(tmp_path / "case.npz")
    content = (tmp_path / "case.npz").read_bytes()
    for size in (0, 10, len(content) // 2):
        (tmp_path / "cut.npz").write_bytes(content[:size])
        with pytest.raises(ValueError, match="damaged"):
            CaseFrames.load(tmp_path / "cut.npz")
