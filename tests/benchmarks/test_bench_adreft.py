import json
import random
from dataclasses import replace
from pathlib import Path

import pytest

from bench import main
from harness import bench_adreft, case_jobs, policy_benchmarks
from harness.contenders import read_plan
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.corpus import Case, Corpus, save_corpus
from roadmend.world.families import FAMILIES
from roadmend.world.runner import run_episode
from roadmend.world.space import sample

CONFIG = Path(__file__).parents[2] / "config"
PLANS = Path(__file__).parent
SMALL = ("--policy", "modular", "--families", "S4", "--no-cost", "--workers", "1")


@pytest.fixture(scope="module")
def corpora(tmp_path_factory):
    """A corpus of two cases of one family; one calls itself a violation, so that every figure has a value."""
    folder = tmp_path_factory.mktemp("corpora")
    family = FAMILIES["S4"]
    cases = []
    for seed, outcome in ((37, "COLLISION"), (4, "GOAL")):  # short ones
        parameters = sample(family.space, random.Random(seed))
        scenario = family.build(parameters, f"S4-{seed}", seed)
        digest = run_episode(scenario, make_policy("modular"), make_repairer("none")).digest
        cases.append(
            Case(f"S4-{seed}", "S4", "test", seed, parameters, outcome, digest, "random", 0, seed, "", 5.0, 20.0)
        )
    save_corpus(Corpus("modular", tuple(cases)), folder / "modular.jsonl")
    return folder


@pytest.fixture
def bench(corpora, tmp_path, capfd):
    """Runs the command on the small corpus; returns exit code, standard output and the lines of complaint."""

    def run(*arguments):
        fixed = ("--corpora", corpora, "--work", tmp_path / "work", *SMALL)
        code = main(["adreft", *map(str, (*fixed, *arguments))])
        out, err = capfd.readouterr()
        return code, out, [line for line in err.splitlines() if line.startswith("roadmend: ")]

    return run


@pytest.fixture
def without_a_model(monkeypatch):
    """The plan, with a model that nobody has trained for one of its methods."""

    def plan(path):
        whole = read_plan(path)
        missing = whole.methods["wo_sr"].model_copy(update={"model": "models/none-{policy}.safetensors"})
        return whole.model_copy(update={"methods": {**whole.methods, "wo_sr": missing}})

    with monkeypatch.context() as patch:
        patch.setattr(bench_adreft, "read_plan", plan)
        yield


@pytest.mark.slow
@pytest.mark.usefixtures("without_a_model")
def test_figures_files_resuming_and_verifying(bench, tmp_path):
    out = tmp_path / "out"
    arguments = ("--methods", "none,rule,wo_sr", "--out", out)
    code, first, complaints = bench(*arguments, "--json")
    assert (code, complaints) == (0, [])
    content = json.loads(first)
    assert [*content["summary"]["modular"]] == ["none", "rule"]
    assert content["corpora"]["modular"]["not_reproduced"] == []
    assert [absence["method"] for absence in content["not_run"]] == ["wo_sr"]
    command = content["provenance"]["command"]
    assert command.startswith("./roadmend bench adreft --policy modular --methods none,rule")
    assert command.endswith(" --no-cost")
    assert {path.name for path in out.iterdir()} == {
        f"adreft-part{end}" for end in (".json", "-cases.json", ".md", "-tables.md", ".html")
    }

    # A second call drives nothing, and says the same.
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(case_jobs, "run_job", lambda _job: pytest.fail("was driven again"))
        assert json.loads(bench(*arguments, "--json")[1])["summary"] == content["summary"]

    # Driven anew it is the same to the bit; a table that says otherwise is found out.
    for name in ("adreft.json", "adreft-cases.json"):
        (out / name.replace("adreft", "adreft-part")).rename(out / name)
    code, said, _ = bench(*arguments, "--verify", "--committed", out)
    assert (code, said.splitlines()[-1]) == (
        0,
        "4 episodes driven again, 0 differences, 0 of them in how an episode ends; 0 of the tables' figures differ",
    )
    kept = json.loads((out / "adreft-cases.json").read_text())
    kept["modular"]["methods"]["rule"]["frames"][1] += 1
    (out / "adreft-cases.json").write_text(json.dumps(kept))
    code, said, _ = bench(*arguments, "--verify", "--committed", out)
    assert code == 1
    assert said.startswith("modular, rule, S4-4: ")
    assert not (tmp_path / "work-verify").exists()


def test_an_error_in_one_episode_is_one_line_and_the_others_are_kept(bench, tmp_path, monkeypatch):
    def broken(name, parameters=None, seed=0, guard=None):
        if name == "rule":
            raise ValueError("no such\nluck")
        return make_repairer(name, parameters, seed, guard)

    monkeypatch.setattr(case_jobs, "make_repairer", broken)
    code, _, complaints = bench("--methods", "none,rule", "--out", tmp_path / "out")
    assert code == 1
    (line,) = complaints
    assert "episodes failed; the first: S4-37, policy modular, " in line
    assert line.endswith("ValueError: no such luck")
    assert not (tmp_path / "out").exists()
    lines = (tmp_path / "work" / "results.jsonl").read_text().splitlines()
    assert len(lines) >= 1 + 2  # the header, and both cases without repair


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["--methods", "rule,magic"], "--methods: there is no 'magic'; choose from none, random_paper, "),
        (["--families", "S9"], "--families: there is no 'S9'; choose from S1, "),
        (["--policy", "mine"], "--policy: there is no 'mine'; choose from modular, neural"),
        (["--fresh-seed", "3"], "--fresh-seed needs --cases"),
        (["--verify", "--robustness"], "--verify goes with the committed cases only"),
        (["--verify", "--committed", "nowhere"], "nowhere/adreft.json: cannot be read"),
        (["--policy", "modular", "--families", "S1"], "holds no test cases of what was asked for"),
    ],
)
def test_refusals_are_one_line_and_leave_nothing(arguments, expected, corpora, tmp_path, capfd):
    work = tmp_path / "work"
    given = ["--corpora", str(corpora), "--work", str(work), "--workers", "1", "--out", str(tmp_path / "out")]
    assert main(["adreft", *given, *arguments]) == 2
    (line,) = [line for line in capfd.readouterr().err.splitlines() if line.startswith("roadmend: ")]
    assert expected in line
    assert not (tmp_path / "out").exists()


def test_a_corpus_of_another_policy_or_another_model_is_refused(bench, corpora, tmp_path, monkeypatch):
    monkeypatch.setattr(policy_benchmarks, "policy_model", lambda _policy: "a" * 64)
    code, _, (line,) = bench("--methods", "none")
    assert code == 2
    assert "was gathered with another model of the policy" in line


def test_fresh_cases_are_held_against_the_committed_table(tmp_path):
    table = {"summary": {"modular": {"rule": {"delta_e": 40.0}, "none": {"delta_e": 0.0}}}}
    (tmp_path / "adreft.json").write_text(json.dumps(table))
    content = {"summary": {"modular": {"rule": {"delta_e": 35.0}, "rss": {"delta_e": 1.0}}, "neural": {}}}
    assert bench_adreft._to_table(content, tmp_path / "adreft.json") == {"modular": {"rule": -5.0}, "neural": {}}
    assert bench_adreft._to_table(content, tmp_path / "none.json") == {}


def test_a_table_needs_every_rival_and_names_what_else_was_left_out():
    plan = read_plan(PLANS / "adreft.yaml")
    rivals = [name for name, method in plan.methods.items() if method.group in ("reference", "rival", "adreft")]
    choice = policy_benchmarks.Choice(
        tuple(plan.policies), tuple(rivals), tuple(FAMILIES), None, "test", None, CONFIG, is_quick=False
    )
    assert bench_adreft._stem(plan, choice) == "adreft"
    content = {"summary": {policy: dict.fromkeys(rivals) for policy in plan.policies}, "not_run": []}
    left = bench_adreft._not_asked_for(plan, content)
    assert {"policy": "neural", "method": "hindsight", "reason": "not asked for"} in left
    assert len(left) == len(plan.policies) * (len(plan.methods) - len(rivals))
    for fewer in (
        replace(choice, methods=tuple(rivals[1:])),
        replace(choice, policies=("modular",)),
        replace(choice, cases=3),
    ):
        assert bench_adreft._stem(plan, fewer) == "adreft-part"
