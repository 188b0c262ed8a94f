import json

import pytest

from roadmend.core.errors import InputError
from roadmend.measures.result_store import RESULTS, ResultStore


def test_results_come_back_and_a_cut_line_is_dropped(tmp_path):
    with ResultStore(tmp_path / "work") as store:
        store.add("one", {"value": 0.1 + 0.2})
        store.add("two", {"value": 2})
    path = tmp_path / "work" / RESULTS
    path.write_bytes(path.read_bytes()[:-5])
    with ResultStore(tmp_path / "work") as store:
        assert store.get("one") == {"value": 0.1 + 0.2}
        assert store.get("two") is None
        store.add("two", {"value": 3})
    with ResultStore(tmp_path / "work") as store:
        assert (len(store), store.get("two")) == (2, {"value": 3})


def test_only_one_process_at_a_time(tmp_path):
    with ResultStore(tmp_path / "work"), pytest.raises(InputError, match="another benchmark is at work here"):
        ResultStore(tmp_path / "work")


def test_foreign_and_damaged_folders_are_refused(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "holiday.txt").write_text("sun")
    with pytest.raises(InputError, match="holds no benchmark's work"):
        ResultStore(tmp_path / "mine")
    with ResultStore(tmp_path / "work") as store:
        store.add("one", {})
    path = tmp_path / "work" / RESULTS
    path.write_text(path.read_text() + json.dumps({"key": 1}) + "\n")
    with pytest.raises(InputError, match=r"line 3: is damaged"):
        ResultStore(tmp_path / "work")
    path.write_text(json.dumps({"format": "other/1"}) + "\n")
    with pytest.raises(InputError, match="is not of the format"):
        ResultStore(tmp_path / "work")
    with pytest.raises(InputError, match="cannot be written"):
        ResultStore(path / "below")
