"""Registries that are open: all ways to name something, and what is said where one leads nowhere."""

import sys

import pytest

from roadmend.core import registry as module
from roadmend.core.errors import InputError
from roadmend.core.registry import OWN, Registry


def a_class(given, thing):
    if not isinstance(thing, type):
        raise InputError(given, "is no class", "name one")
    return thing


def of_model(given):
    return ("first", dict) if given.endswith(".model") else None


THINGS = Registry("thing", "roadmend.things", {"first": int, "second": str}, a_class, of_model, "a model file")


def refusal(given, find=THINGS.find):
    with pytest.raises(InputError) as caught:
        find(given)
    assert "\n" not in str(caught.value)
    return str(caught.value)


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """Installs packages, each with its entry points; what was looked up before is forgotten."""
    monkeypatch.setattr(sys, "path", [str(tmp_path / "site"), *sys.path])

    def install(package, points, text="class Thing:\n    pass\n"):
        name = package.replace("-", "_")
        information = tmp_path / "site" / f"{name}-1.2.dist-info"
        information.mkdir(parents=True)
        (information / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {package}\nVersion: 1.2\n")
        lines = [f"{point} = {name}:Thing" for point in points]
        (information / "entry_points.txt").write_text("[roadmend.things]\n" + "\n".join(lines) + "\n")
        (tmp_path / "site" / f"{name}.py").write_text(text)
        module._offered.cache_clear()

    yield install
    monkeypatch.undo()
    module._offered.cache_clear()


def test_a_name_of_ours_is_found_without_an_import():
    found = THINGS.find("first")
    assert (found.entry, found.origin, found.label, found.modules) == (int, OWN, "first", ())


def test_a_model_file_is_what_its_kind_says():
    found = THINGS.find("/there/mine.model")
    assert (found.given, found.label, found.entry) == ("/there/mine.model", "first", dict)
    assert not found.is_foreign


def test_a_class_of_the_current_folder_is_found_and_the_folder_comes_last(own, tmp_path):
    name = own("class Thing:\n    class Inner:\n        pass\n")
    found = THINGS.find(f"{name}:Thing")
    assert found.entry.__name__ == "Thing"
    assert (found.label, found.modules) == ("Thing", (name,))
    assert found.origin == str(tmp_path / "theirs" / f"{name}.py")
    assert THINGS.find(f"{name}:Thing.Inner").entry is found.entry.Inner
    assert sys.path[-1] == str(tmp_path / "theirs")
    assert sys.path.count(sys.path[-1]) == 1


def test_a_file_of_the_current_folder_does_not_get_in_the_way_of_the_standard_library(own):
    own("raise RuntimeError", "colorsys")
    sys.modules.pop("colorsys", None)
    assert "has no 'Thing'" in refusal("colorsys:Thing")


def test_a_class_that_is_imported_from_elsewhere_counts_with_both_files(own):
    inner = own("class Thing:\n    pass\n")
    outer = own(f"from {inner} import Thing\n")
    assert THINGS.find(f"{outer}:Thing").modules == (outer, inner)


def test_an_installed_package_offers_more(installed):
    installed("thing-shop", ["third"])
    found = THINGS.find("third")
    assert found.entry.__name__ == "Thing"
    assert found.origin.startswith("thing-shop 1.2, ")
    assert THINGS.names == ["first", "second", "third"]
    assert [each.given for each in THINGS] == THINGS.names
    assert "did you mean third?" in refusal("thrid")


def test_a_name_that_ros_would_not_take_has_a_label_that_it_takes(installed):
    installed("thing-mall", ["late-brake"])
    found = THINGS.find("late-brake")
    assert (found.given, found.label) == ("late-brake", "late_brake")


def test_a_name_of_ours_is_never_anybody_elses(installed):
    installed("thing-thief", ["first"])
    assert THINGS.find("first").entry is int
    assert THINGS.names == ["first", "second"]


def test_a_name_that_two_packages_offer_names_both(installed):
    installed("shop-one", ["third"])
    installed("shop-two", ["third"])
    assert "is offered by shop-one 1.2 and shop-two 1.2" in refusal("third")


def test_a_package_that_fails_is_among_all_as_an_error(installed):
    installed("shop-broken", ["third"], "1 / 0\n")
    *ours, broken = THINGS
    assert len(ours) == 2
    assert isinstance(broken, InputError)
    assert "shop_broken cannot be imported: ZeroDivisionError" in str(broken)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ("frist", "thing: there is no 'frist', did you mean first?; choose one of first, second, or give "),
        ("", "there is no ''; choose one of"),
        ("nowhere_at_all:Thing", "there is no module 'nowhere_at_all'; run from the folder that it is in"),
        ("nowhere.at.all:Thing", "there is no module 'nowhere'"),
        ("json.nothing:Thing", "there is no module 'json.nothing'"),
        (":Thing", "is no package.module:Class"),
        ("json:", "is no package.module:Class"),
        ("json:JSONDecodr", "has no 'JSONDecodr', did you mean JSONDecoder?"),
        ("json:loads", "is no class"),
    ],
)
def test_what_leads_nowhere_is_said(given, said):
    assert said in refusal(given)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("import no_such_library", "ModuleNotFoundError: No module named 'no_such_library' ({file} line 1)"),
        ("def f(:", "SyntaxError: "),
        ("raise RuntimeError('two\\nlines')", "RuntimeError: two lines ({file} line 1)"),
        ("import sys; sys.exit('no')", "SystemExit: no"),
    ],
)
def test_a_module_that_fails_is_said_in_one_line(own, tmp_path, text, said):
    name = own(text)
    told = refusal(f"{name}:Thing")
    assert f"{name} cannot be imported: " in told
    assert said.format(file=tmp_path / "theirs" / f"{name}.py") in told


def test_a_class_that_is_called_as_one_of_ours_is_refused(own):
    assert "is called 'first' as one of ours" in refusal(f"{own('class first: pass')}:first")


def test_what_a_file_names_makes_nobody_run_code(own):
    name = own("raise RuntimeError")
    assert "runs only where the user names it" in refusal(f"{name}:Thing", THINGS.find_installed)
    assert name not in sys.modules
    assert THINGS.find_installed("second").entry is str
