from dataclasses import dataclass

import numpy as np
import pytest

from roadmend.core.array_file import ArrayRecord


@dataclass(frozen=True)
class Record(ArrayRecord):
    name: str
    end: float
    count: int
    values: np.ndarray


RECORD = Record("a case", 1.5, 3, np.arange(6, dtype=np.float32).reshape(2, 3))


def test_a_record_comes_back_as_it_was(tmp_path):
    RECORD.save(tmp_path / "r.npz")
    again = Record.load(tmp_path / "r.npz")
    assert (again.name, again.end, again.count) == (RECORD.name, RECORD.end, RECORD.count)
    assert again.values.dtype == np.float32
    np.testing.assert_array_equal(again.values, RECORD.values)
    assert [path.name for path in tmp_path.iterdir()] == ["r.npz"]


@pytest.mark.parametrize("keep", [0.0, 0.5, 0.98])
def test_a_damaged_file_is_said_to_be_so(tmp_path, keep):
    path = tmp_path / "r.npz"
    RECORD.save(path)
    content = path.read_bytes()
    path.write_bytes(content[: int(keep * len(content))])
    with pytest.raises(ValueError, match="is damaged"):
        Record.load(path)


def test_a_file_of_something_else_and_a_missing_one_are_told_apart(tmp_path):
    np.savez(tmp_path / "other.npz", values=np.zeros(2))
    with pytest.raises(ValueError, match="is damaged"):
        Record.load(tmp_path / "other.npz")
    with pytest.raises(FileNotFoundError):
        Record.load(tmp_path / "none.npz")
