import importlib
import os
import sys

import pytest

from roadmend.core import source_digest as module
from roadmend.core.errors import InputError
from roadmend.core.source_digest import meaning, source_digest

CODE = '''
"""Says something."""

def add(a, b):
    """Adds."""
    return a + b  # of course
'''


def test_comments_docstrings_and_layout_do_not_count_but_code_does():
    same = "def add(a,\n        b):\n    return (a + b)\n"
    assert meaning(CODE) == meaning(same)
    assert meaning(CODE) != meaning(CODE.replace("a + b", "a - b"))


def test_only_what_is_imported_counts():
    rule = source_digest(["roadmend.repair.rule"])
    assert rule == source_digest(["roadmend.repair.rule"])
    assert rule == source_digest(["roadmend.repair.rule", "roadmend.repair.actions", "roadmend.policies.registry"])
    assert rule != source_digest(["roadmend.repair.rule", "roadmend.repair.rss"])


def test_whoever_asks_the_table_of_methods_has_the_guard_and_not_every_method():
    guard = source_digest(["roadmend.repair.guard", "roadmend.repair.none"])
    assert source_digest(["roadmend.repair.registry"]) == guard
    assert source_digest(["roadmend.repair.registry", "roadmend.repair.random"]) != guard


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A package whose digests are of its files as they are at every call."""
    files = {
        "__init__.py": "",
        "top.py": "import json\nfrom house.room.inner import a\n",
        "room/__init__.py": "REGISTRY = {}\n",
        "room/inner.py": "def a():\n    from house import late\n    return late\n",
        "room/beside.py": "import importlib.resources\n",
        "room/words/first.yaml": "a: 1\n",
        "late.py": "from .deep import value\n",
        "deep.py": "import numpy\nvalue = 1\n",
        "other.py": "value = 1\n",
    }
    house = tmp_path / "house"
    for name, text in files.items():
        (house / name).parent.mkdir(parents=True, exist_ok=True)
        (house / name).write_text(text)
    monkeypatch.syspath_prepend(tmp_path)

    def digest(*modules):
        for cached in (module._digest_of_ours, module._data_digest, module._version):
            cached.cache_clear()
        module._THEIRS.clear()
        return source_digest(modules)

    yield house, digest
    monkeypatch.undo()
    digest("roadmend.core.errors")


@pytest.mark.parametrize("changed", ["top.py", "room/__init__.py", "room/inner.py", "late.py", "deep.py"])
def test_lazy_and_relative_imports_and_the_packages_around_count(package, changed):
    house, digest = package
    before = digest("house.top")
    (house / "other.py").write_text("value = 2\n")
    (house / "room" / "words" / "first.yaml").write_text("a: 2\n")
    assert digest("house.top") == before
    (house / changed).write_text((house / changed).read_text() + "more = 1\n")
    assert digest("house.top") != before


def test_files_beside_a_users_module_count_and_installed_packages_by_version(package):
    house, digest = package
    (house.parent / "mine.py").write_text("import beside_mine\nimport numpy\n")
    (house.parent / "beside_mine.py").write_text("import beside_that\n")
    (house.parent / "beside_that.py").write_text("value = 1\n")
    before = digest("mine")
    assert digest("mine") == before
    (house.parent / "beside_that.py").write_text("value = 2\n")
    assert digest("mine") != before


def test_a_users_folder_without_an_init_file_counts(package):
    house, digest = package
    (house.parent / "mine.py").write_text("def gain():\n    from helpers.deep.gains import GAIN\n    return GAIN\n")
    gains = house.parent / "helpers" / "deep" / "gains.py"
    gains.parent.mkdir(parents=True)
    gains.write_text("GAIN = 1\n")
    before = digest("mine")
    gains.write_text("GAIN = 2\n")
    assert digest("mine") != before


def test_what_is_taken_from_a_module_is_no_file_beside_it(package):
    house, digest = package
    (house.parent / "mine.py").write_text("from sys import gains\nfrom beside_mine import gains\n")
    (house.parent / "beside_mine.py").write_text("gains = 1\n")
    before = digest("mine")
    (house.parent / "gains.py").write_text("this is no Python\n")
    assert digest("mine") == before


@pytest.fixture
def edited(tmp_path, monkeypatch):
    """A module that is imported, and a way to edit it."""
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)
    file = tmp_path / "edited_by_me.py"

    def edit(text):
        file.write_text(text)
        os.utime(file, (0, edit.time))
        edit.time += 1

    edit.time = 1_000_000_000
    edit("gain = 1\n")
    yield importlib.import_module("edited_by_me"), edit
    sys.modules.pop("edited_by_me", None)


def test_a_module_that_was_edited_and_reloaded_has_another_digest(edited):
    mine, edit = edited
    before = source_digest([mine.__name__])
    edit("gain = 2\n")
    importlib.reload(mine)
    assert mine.gain == 2
    after = source_digest([mine.__name__])
    assert before != after == source_digest([mine.__name__])


def test_a_module_that_was_edited_and_not_reloaded_is_refused(edited):
    mine, edit = edited
    before = source_digest([mine.__name__])
    edit("gain = 1  # of course\n")
    assert source_digest([mine.__name__]) == before
    for text in ("gain = 2\n", "gain = \n"):
        edit(text)
        with pytest.raises(InputError, match="edited_by_me: was edited after it was imported"):
            source_digest([mine.__name__])
    edit("gain = 1\n")
    assert source_digest([mine.__name__]) == before


def test_data_that_a_module_reads_from_its_package_counts(package):
    house, digest = package
    before = digest("house.room.beside")
    (house / "room" / "words" / "first.yaml").write_text("a: 2\n")
    changed = digest("house.room.beside")
    (house / "room" / "words" / "second.yaml").write_text("a: 2\n")
    assert len({before, changed, digest("house.room.beside")}) == 3


def test_another_version_of_a_library_counts(package, monkeypatch):
    _, digest = package
    before = digest("house.top")
    monkeypatch.setattr(module.metadata, "version", {"numpy": "0.1"}.__getitem__)
    assert digest("house.top") != before


def test_what_has_no_source_is_refused():
    with pytest.raises(InputError, match="nowhere: has no source"):
        source_digest(["nowhere"])


def test_another_package_is_followed_into_roadmend(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    package = tmp_path / "stranger"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "policy.py").write_text("import json\nfrom stranger.helper import help_out\n")
    (package / "helper.py").write_text("from roadmend.repair.rule import RuleRepair\n")
    digests = {source_digest(["stranger.policy"]), source_digest(["stranger.helper"])}
    assert not digests & {source_digest(["roadmend.repair.rule"])}
    assert len(digests) == 2
