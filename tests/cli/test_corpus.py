"""``roadmend corpus`` in the real world: built, verified, shown, and refused in one line."""

import dataclasses
import json

import pytest

from roadmend.cli import corpus
from roadmend.cli.main import main
from roadmend.core.resources import config_folder
from roadmend.world.corpus import load_corpus, save_corpus
from roadmend.world.families import FAMILIES

PLAN = """
most_campaigns: 1
test: {violations: 0, successes: 3, first_seed: 1, techniques: [random], budget: 4, least_distance: 0.0}
validation: {violations: 0, successes: 0, first_seed: 2, techniques: [random], budget: 1, least_distance: 0.0}
training: {violations: 0, successes: 0, first_seed: 3, techniques: [random], budget: 1, least_distance: 0.0}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("corpus")
    (folder / "plan.yaml").write_text(PLAN)
    assert main(build(folder, "first.jsonl")) == 0
    return folder


def build(folder, name, *more):
    arguments = [
        "--searches",
        str(folder / "searches"),
        "--out",
        str(folder / name),
        "--plan",
        str(folder / "plan.yaml"),
    ]
    return ["corpus", "build", "--family", "S4", "--workers", "1", *arguments, *more]


def verify(file, *more):
    return main(["corpus", "verify", "--corpus", str(file), "--workers", "1", *more])


def test_what_was_built_is_real_and_repeats(folder, capsys):
    corpus = load_corpus(folder / "first.jsonl")
    assert [case.outcome for case in corpus.cases] == ["GOAL"] * 3
    assert all(case.duration > 1.0 and case.text.startswith("route completed") for case in corpus.cases)
    assert corpus.command == "roadmend corpus build --policy modular --family S4"
    assert main(build(folder, "second.jsonl")) == 0
    assert corpus.digest in capsys.readouterr().out
    assert (folder / "second.jsonl").read_bytes() == (folder / "first.jsonl").read_bytes()
    assert verify(folder / "first.jsonl", "--json") == 0
    printed = json.loads(capsys.readouterr().out)
    assert (printed["verified"], printed["differing"]) == (3, [])


def test_a_difference_is_found(folder, capsys):
    corpus = load_corpus(folder / "first.jsonl")
    wrong = dataclasses.replace(corpus.cases[1], seed=corpus.cases[1].seed + 1)
    save_corpus(dataclasses.replace(corpus, cases=(corpus.cases[0], wrong, corpus.cases[2])), folder / "wrong.jsonl")
    assert verify(folder / "wrong.jsonl") == 1
    out = capsys.readouterr().out
    assert wrong.name in out
    assert "2 of 3 cases came to the same" in out
    save_corpus(dataclasses.replace(corpus, model="0123"), folder / "other.jsonl")
    assert verify(folder / "other.jsonl", "--cases", "1") == 1
    assert "gathered with model 0123" in capsys.readouterr().err


def test_a_corpus_is_renewed_without_what_comes_to_something_else(folder, capsys):
    corpus = load_corpus(folder / "first.jsonl")
    first, second, third = corpus.cases
    stale = dataclasses.replace(first, digest="0" * 64, duration=1.0)
    other = dataclasses.replace(second, outcome="COLLISION", blame="FRONT")
    old = dataclasses.replace(corpus, cases=(stale, other, third), dropped=2, version="0.0.9")
    save_corpus(old, folder / "old.jsonl")
    again = ["corpus", "renew", "--corpus", str(folder / "old.jsonl"), "--out", str(folder / "new.jsonl")]
    assert main([*again, "--workers", "1"]) == 0
    assert "2 cases, 1 of them with another trajectory, 1 left out" in capsys.readouterr().out
    assert load_corpus(folder / "new.jsonl") == dataclasses.replace(corpus, cases=(first, third), dropped=3)
    assert sorted(file.name for file in folder.glob("new*")) == ["new.jsonl"]


def test_splits_of_another_corpus_take_the_place_of_those_of_the_same_name(folder, capsys):
    corpus = load_corpus(folder / "first.jsonl")
    first, second, third = corpus.cases
    training = dataclasses.replace(first, name="kept", split="training")
    twice = dataclasses.replace(third, name="twice", split="training")
    save_corpus(dataclasses.replace(corpus, cases=(training, twice, second)), folder / "old.jsonl")
    save_corpus(dataclasses.replace(corpus, cases=(third,), fleeting=4), folder / "fresh.jsonl")
    asked = ["corpus", "renew", "--corpus", str(folder / "old.jsonl"), "--with", str(folder / "fresh.jsonl")]
    assert main([*asked, "--out", str(folder / "new.jsonl"), "--workers", "1"]) == 0
    capsys.readouterr()
    joined = load_corpus(folder / "new.jsonl")
    assert [case.name for case in joined.cases] == ["kept", third.name]
    assert joined.fleeting == 4
    assert "training by" in joined.command


def test_a_shortage_is_told(folder, capsys):
    text = PLAN.replace("validation: {violations: 0", "validation: {violations: 50")
    (folder / "more.yaml").write_text(text)
    assert main([*build(folder, "more.jsonl"), "--plan", str(folder / "more.yaml")]) == 1
    assert "of 50 violations after 1 searches" in capsys.readouterr().err
    assert main([*build(folder, "more.jsonl"), "--plan", str(folder / "more.yaml"), "--allow-partial"]) == 0


def test_counts_are_shown(folder, capsys):
    assert main(["corpus", "show", "--corpus", str(folder / "first.jsonl"), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["cases"] == shown["families"]["S4"]["test"]["successes"] == 3
    assert shown["digest"] == load_corpus(folder / "first.jsonl").digest
    assert main(["corpus", "show", "--corpus", str(folder / "first.jsonl")]) == 0
    assert "S4" in capsys.readouterr().out


def test_no_other_policy_than_that_named_is_worked_on(folder, tmp_path, capsys):
    named = ["show", "--corpus", str(folder / "first.jsonl"), "--policy", "neural"]
    assert main(["corpus", *named]) == 2
    assert "is a corpus of the policy 'modular'; give one of 'neural'" in capsys.readouterr().err
    assert main(["corpus", *named[:-1], "modular"]) == 0
    model = tmp_path / "neural.safetensors"  # a user's own, with the name of one that ships
    model.write_bytes((config_folder() / "models" / "neural.safetensors").read_bytes())
    for command in (["show"], ["verify", "--cases", "1"], ["renew", "--out", str(tmp_path / "new.jsonl")]):
        assert main(["corpus", *command, "--policy", str(model)]) == 2
        assert "is a corpus of the policy 'neural'" in capsys.readouterr().err
    assert [*tmp_path.iterdir()] == [model]


def test_families_of_installed_packages_are_counted_too(folder, monkeypatch, capsys):
    monkeypatch.setattr("roadmend.world.corpus._family", lambda _: FAMILIES["S4"])  # as if a package had brought it
    loaded = load_corpus(folder / "first.jsonl")
    cases = [dataclasses.replace(case, family="Crossing") for case in loaded.cases]
    counts = corpus._content(dataclasses.replace(loaded, cases=cases))["families"]
    assert counts["Crossing"]["test"]["successes"] == 3
    corpus._show(dataclasses.replace(loaded, cases=cases))
    assert "Crossing" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["build", "--families", "S1,S9", "--searches", "x", "--out", "y"], "there is no 'S9'"),
        (["build", "--plan", "nothing.yaml", "--searches", "x", "--out", "y"], "no such file"),
        (["build", "--fresh-seed", "1", "--allow-partial", "--searches", "x", "--out", "y"], "--fresh-seed"),
        (["build", "--fresh-seed", "99999999", "--searches", "x", "--out", "y"], "is not in the range 0<=x<=2137482"),
        (["verify", "--corpus", "nothing.jsonl"], "no such file"),
        (["show", "--corpus", "nothing.jsonl"], "no such file"),
    ],
)
def test_bad_input_is_refused_in_one_line(tmp_path, monkeypatch, capsys, arguments, said):
    monkeypatch.chdir(tmp_path)
    assert main(["corpus", *arguments]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert said in line
    assert not [*tmp_path.iterdir()]
