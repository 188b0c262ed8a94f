from concurrent.futures import ThreadPoolExecutor

import pytest

from roadmend.core.claim import check_name, claim_folder, claim_numbered
from roadmend.core.errors import InputError


def attempt(parent):
    try:
        return claim_folder(parent, "bag")
    except InputError:
        return None


def test_of_many_that_claim_a_folder_one_gets_it(tmp_path):
    with ThreadPoolExecutor(16) as pool:
        won = [folder for folder in pool.map(attempt, [tmp_path / "bags"] * 64) if folder]
    assert won == [tmp_path / "bags" / "bag"]


def test_numbered_folders_are_all_different(tmp_path):
    with ThreadPoolExecutor(16) as pool:
        names = {folder.name for folder in pool.map(claim_numbered, [tmp_path] * 32, ["run"] * 32)}
    assert names == {"run", *(f"run-{number}" for number in range(2, 33))}


@pytest.mark.parametrize("name", ["", ".", "..", "a/b", "/a", "a/", "a\0b"])
def test_a_path_is_no_name(name):
    with pytest.raises(InputError, match=r"--name: .* is no name for a folder"):
        check_name("--name", name)


@pytest.mark.parametrize("name", ["a", "a.b", ".hidden", "ä b", "..."])
def test_a_name_is_taken_as_it_is(name):
    check_name("--name", name)


def test_a_file_in_the_way_is_one_line(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="file"):
        claim_folder(tmp_path / "file", "bag")
    with pytest.raises(InputError, match="exists already"):
        claim_folder(tmp_path, "file")
    with pytest.raises(InputError):
        claim_numbered(tmp_path / "file", "bag")
