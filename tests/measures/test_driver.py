"""Every kind of kept work has another key when the code that decides it changes, wherever that code lies."""

import dataclasses
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import pytest

from harness import hindsight_file
from roadmend.core import source_digest as digests
from roadmend.core.journal import entry_key
from roadmend.measures.driver import driver_key
from roadmend.safe.driving import CrashTestJob, Task
from roadmend.search.campaign import Campaign
from roadmend.search.evaluation import Subject
from roadmend.search.persistence import PersistenceTeller
from roadmend.search.registry import read_technique_parameters
from roadmend.search.rerun import Rerunner
from roadmend.sera.evaluation_episode import EvaluationJob
from roadmend.training import dagger
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.adreft.trial_plan import TrialPlan
from roadmend.training.adreft.trials import trial_keys
from roadmend.world.corpus import Case
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_networks import NetworkFile
from tests.core.own_code import METHOD, POLICY
from tests.safe.crashes import ALL, role
from tests.training.cases import Drawn

CORPUS = Path(__file__).parents[2] / "config" / "corpora" / "modular.jsonl"
CASE = Case.parse(CORPUS.read_text().splitlines()[1])  # of thousands
RECIPE = Recipe("modular", "rich", 1)
DRAWN = [Drawn("S5", 3)]


def search_key():
    campaign = Campaign(Subject("S5", "modular", "rss", 1), "random", read_technique_parameters("random"))
    return campaign.settings["code"]


def evaluation_key():
    job = EvaluationJob(sample_scenario("S5", 3), "modular", "rss", Path(), "failures", driver_key("modular", "rss"))
    return job.key


def safe_key():
    return CrashTestJob(Task.TEST, role(ALL["rear end"]), "modular", 0, 0, 1, Path(), None).key


KINDS = {
    "driver": partial(driver_key, "modular", "rss"),
    "search": search_key,
    "rerun": lambda: Rerunner("modular", map)._key(CASE),
    "evaluation": evaluation_key,
    "safe": safe_key,
    "frames": lambda: RECIPE.keys(DRAWN)[0],
    "trials": lambda: trial_keys(DRAWN, RECIPE, TrialPlan(2, 2, 0, 4, 1))[0],
    "bound": lambda: entry_key([hindsight_file.__name__], driver_key("modular")),
}
OF_EVERY_DRIVER = ("roadmend.world.ego", "roadmend.repair.rss_kernel", "roadmend.policies.modular")


@pytest.fixture
def change(monkeypatch, tmp_path):
    """Adds a line to a module, as far as digests can see; what they know of the others, they need not read again."""
    found, known = digests._path, digests._read_ours

    def forget():
        digests._digest_of_ours.cache_clear()
        digests._THEIRS.clear()

    def change(name):
        assert found(name) is not None, name
        copy = tmp_path / found(name).name
        copy.write_text(found(name).read_text() + "\nmore = 1\n")
        monkeypatch.setattr(digests, "_path", lambda each: copy if each == name else found(each))
        monkeypatch.setattr(
            digests, "_read_ours", lambda each: known.__wrapped__(each) if each == name else known(each)
        )
        forget()

    yield change
    monkeypatch.undo()
    forget()


@pytest.mark.parametrize("name", OF_EVERY_DRIVER)
def test_a_change_in_what_drives_is_another_key_of_every_kind(change, name):
    before = {kind: key() for kind, key in KINDS.items()}
    assert before == {kind: key() for kind, key in KINDS.items()}
    change(name)
    assert not {kind for kind, key in KINDS.items() if key() == before[kind]}


def test_lessons_of_the_expert_hang_on_the_expert_and_the_world(change):
    before = entry_key([dagger.__name__])
    for name in ("roadmend.policies.expert", "roadmend.world.ego", "roadmend.repair.guard"):
        change(name)
        assert entry_key([dagger.__name__]) != before


@pytest.mark.parametrize(
    ("kind", "name"),
    [
        ("search", "roadmend.search.danger"),
        ("safe", "roadmend.safe.layout"),
        ("trials", "roadmend.training.adreft.blinded_policy"),
        ("frames", "roadmend.repair.adreft.rich_kernel"),
        ("evaluation", "roadmend.recording.writer"),
        ("bound", "harness.pulse"),
    ],
)
def test_a_change_in_what_is_measured_is_another_key(change, kind, name):
    before, driver = KINDS[kind](), driver_key("modular")
    change(name)
    assert KINDS[kind]() != before
    assert driver_key("modular") == driver


@pytest.mark.parametrize("name", ["roadmend.policies.neural", "roadmend.repair.predictive", "roadmend.cli.main"])
def test_a_change_in_what_does_not_drive_is_none(change, name):
    before = driver_key("modular", "rule")
    change(name)
    assert driver_key("modular", "rule") == before


def test_a_model_counts_by_what_is_in_it_and_not_by_its_place(tmp_path):
    models = Path(__file__).parents[2] / "config" / "models"
    copy = tmp_path / "copy.safetensors"
    copy.write_bytes((models / "adreft-modular.safetensors").read_bytes())
    assert driver_key("modular", "adreft", {"model": str(copy)}) == driver_key(
        "modular", "adreft", {"model": "modular"}
    )
    assert driver_key("modular", "adreft", {"model": "neural"}) != driver_key("modular", "adreft", {"model": "modular"})
    rates = [driver_key("modular", "model", {"model": name}) for name in ("modular", "neural")]
    assert rates[0] != rates[1]
    neural = tmp_path / "mine.safetensors"
    neural.write_bytes((models / "neural.safetensors").read_bytes())
    assert driver_key(str(neural)) == driver_key("neural") != driver_key("deep_sets")


def test_another_network_at_the_same_place_is_another_key(tmp_path):
    net = tmp_path / "mine.net.xml"
    scenario = sample_scenario("S5", 3).model_copy(update={"network": NetworkFile(path=str(net))})
    case = SimpleNamespace(scenario=lambda: scenario, duration=9.0)
    kinds = [
        lambda: Rerunner("modular", map)._key(case),
        lambda: PersistenceTeller("modular", map, None)._key(case, 5),
        lambda: EvaluationJob(scenario, "modular", "rss", Path(), "failures", "driver").key,
    ]
    keys = []
    for text in ("<net/>", "<net></net>"):
        net.write_text(text)
        keys.append([key() for key in kinds])
        assert keys[-1] == [key() for key in kinds]
    assert all(before != after for before, after in zip(*keys, strict=True))


def test_another_seed_is_another_key_of_a_job():
    job = CrashTestJob(Task.TEST, role(ALL["rear end"]), "modular", 0, 0, 1, Path(), None)
    assert job.key != dataclasses.replace(job, seed=1).key


@pytest.mark.parametrize(("kind", "text"), [("policy", POLICY), ("method", METHOD)])
def test_a_change_in_code_of_the_users_own_is_another_key(own, change, kind, text):
    name = own(text)
    given = {"policy": "modular", "method": "rss", kind: f"{name}:{'Careful' if kind == 'policy' else 'Near'}"}
    before = driver_key(**given)
    assert before == driver_key(**given) != driver_key("modular", "rss")
    change(name)
    assert driver_key(**given) != before


def test_a_model_of_the_users_own_counts_by_the_digest_that_its_class_tells(own):
    name = own(POLICY + "\nclass A(Careful):\n    model_digest = 'a'\n\nclass B(Careful):\n    model_digest = 'b'\n")
    assert len({driver_key(f"{name}:{each}") for each in ("Careful", "A", "B")}) == 3


def test_a_model_file_is_the_same_driver_as_the_model_that_ships():
    models = Path(__file__).parents[2] / "config" / "models"
    assert driver_key(str(models / "neural.safetensors")) == driver_key("neural")
    path = str(models / "adreft-modular.safetensors")
    assert driver_key("modular", path) == driver_key("modular", "adreft")
