import pytest

from roadmend.core.errors import InputError
from roadmend.core.whole_file import write_text, write_texts, written_beside


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_text_takes_its_place_and_nothing_stays_beside(tmp_path):
    path = tmp_path / "new" / "a.txt"
    write_text(path, "überall")
    assert path.read_text(encoding="utf-8") == "überall"
    assert names(path.parent) == ["a.txt"]


def test_the_old_file_stays_until_the_block_ends(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with written_beside(path) as beside:
        beside.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"


def test_a_failure_leaves_the_old_file_and_nothing_half_written(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")

    def stop_halfway() -> None:
        with written_beside(path) as beside:
            beside.write_text("half")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        stop_halfway()
    assert path.read_text() == "old"
    assert names(tmp_path) == ["a.txt"]


def test_a_place_that_is_a_folder_is_refused_in_one_line(tmp_path):
    (tmp_path / "a.txt").mkdir()
    with pytest.raises(InputError, match=r"a\.txt: cannot be written \(Is a directory\); choose a writable folder"):
        write_text(tmp_path / "a.txt", "text")
    assert names(tmp_path) == ["a.txt"]


def test_files_that_belong_together(tmp_path):
    write_texts(tmp_path / "new", {"a.md": "A", "b.json": "B"})
    assert names(tmp_path / "new") == ["a.md", "b.json"]
    assert (tmp_path / "new" / "b.json").read_text() == "B"


def test_no_file_of_a_set_takes_its_place_where_one_cannot_be_written(tmp_path):
    (tmp_path / "a.md").write_text("old")
    (tmp_path / "b.json").mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        write_texts(tmp_path, {"a.md": "A", "b.json": "B"})
    assert (tmp_path / "a.md").read_text() == "old"
