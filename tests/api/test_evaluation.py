"""Evaluation from Python: by name, of classes and of objects; kept, saved and told."""

import json
import sys

import pytest

from roadmend import InputError, evaluate, sample_scenario
from roadmend.measures.evaluation import run_trials, trials_of


@pytest.fixture(scope="module")
def scenarios():
    return [sample_scenario("S3", number).model_copy(update={"time_limit": 4.0}) for number in (3, 4)]


class Nothing(dict):
    """A journal that keeps nothing."""

    def add(self, key, entry):
        pass


def results(driven):
    return [each.result for each in driven]


@pytest.mark.slow
def test_classes_and_objects_are_driven_as_names_are(theirs, scenarios):
    policies, repairs = theirs
    names = f"{policies.__name__}:Careful", f"{repairs.__name__}:Near"
    by_name = results(run_trials(trials_of(scenarios, names[:1], names[1:]), Nothing(), 1))
    told = []
    of_class = evaluate(scenarios, policies.Careful, repairs.Near, progress=lambda *done: told.append(done))
    of_object = evaluate(scenarios, policies.Careful(), repairs.Near(repairs.Settings()))
    assert results(of_class.driven) == by_name == results(of_object.driven)
    assert [*of_class.figures[names[0]]] == ["none", "random", names[1]]
    assert of_class.figures == of_object.figures
    assert told[-1] == (6, 6)
    assert str(of_class).splitlines()[0].startswith("| policy | repair |")
    assert len(str(of_class).splitlines()) == 5


@pytest.mark.slow
def test_classes_drive_in_workers_are_kept_and_the_files_tell_all(theirs, scenarios, tmp_path):
    policies, _ = theirs
    first = evaluate(scenarios, policies.Careful, "rule", workers=2, folder=tmp_path / "kept")
    kept = (tmp_path / "kept" / "results.jsonl").read_text()
    again = evaluate(scenarios, policies.Careful, "rule", folder=tmp_path / "kept")
    assert again == first
    assert (tmp_path / "kept" / "results.jsonl").read_text() == kept
    page = first.save(tmp_path / "kept")
    assert page.name == "evaluation.html"
    told = json.loads((tmp_path / "kept" / "evaluation.json").read_text())
    assert told["policies"] == json.loads(json.dumps(first.figures))
    assert len(told["episodes"]) == 6
    text = page.read_text()
    assert all(f"<td>{name}</td>" in text for name in (f"{policies.__name__}:Careful", "rule", "random", "S3-4"))
    frame = first.episodes
    assert [*frame.scenario.unique()] == ["S3-3", "S3-4"]
    assert set(frame.method) == {"none", "random", "rule"}


def test_an_episode_that_fails_is_a_line(theirs, scenarios, tmp_path):
    policies, _ = theirs
    found = evaluate(scenarios[:1], policies.Late(), "none")
    assert len(found.faults) == 2
    assert all("Late" in line and "ZeroDivisionError" in line for line in found.faults)
    assert str(found).endswith("\n".join(found.faults))
    assert "ZeroDivisionError" in found.save(tmp_path).read_text()


def test_without_what_draws_pages_the_figures_are_saved_all_the_same(theirs, scenarios, tmp_path, monkeypatch):
    policies, _ = theirs
    found = evaluate(scenarios[:1], policies.Late(), "none")
    for module in ("jinja2", "matplotlib"):
        monkeypatch.setitem(sys.modules, module, None)
    for module in ("roadmend.reports.evaluation_page", "roadmend.reports.page"):
        monkeypatch.delitem(sys.modules, module, raising=False)
    with pytest.raises(InputError, match=r"needed here and not installed.*\./roadmend set-up reports"):
        found.save(tmp_path)
    assert {path.name for path in tmp_path.glob("*.*")} == {"evaluation.json", "evaluation.md"}


def test_what_cannot_be_told_apart_or_is_not_there_is_refused(theirs, scenarios):
    policies, _ = theirs
    with pytest.raises(InputError, match="scenarios: two have the name 'S3-3'"):
        evaluate([scenarios[0], scenarios[0]])
    with pytest.raises(InputError, match="scenarios: there is none"):
        evaluate([])
    with pytest.raises(InputError, match=r"policies: two are called '.*Careful'"):
        evaluate(scenarios, [policies.Careful, policies.Careful()])
    with pytest.raises(InputError, match="cannot answer a plain scene"):
        evaluate(scenarios, policies.Never())
    for nobody in ("none", "random"):
        with pytest.raises(InputError, match=f"policy: there is no '{nobody}'"):
            evaluate(scenarios, nobody)
    with pytest.raises(InputError, match="policies: there is none; give one at least"):
        evaluate(scenarios, [])
    with pytest.raises(InputError, match="scenario: is neither a Scenario nor a path, but NoneType"):
        evaluate(None)
    with pytest.raises(InputError, match="did you mean adreft"):
        evaluate(scenarios, "modular", "adrft")


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"futures": -1}, "futures: -1 is no whole number from 0"),
        ({"futures": 0.5}, "futures: 0.5 is no whole number from 0"),
        ({"workers": 0}, "workers: 0 is no whole number from 1"),
        ({"workers": "2"}, "workers: '2' is no whole number from 1"),
    ],
)
def test_numbers_that_count_nothing_are_refused(scenarios, given, said):
    with pytest.raises(InputError, match=said):
        evaluate(scenarios, **given)


def test_the_report_says_with_which_settings_methods_ran(theirs, scenarios):
    policies, _ = theirs
    found = evaluate(scenarios[:1], ["modular", policies.Late()], ["rss", "none"])
    assert [*found.fitting] == ["modular"]
    assert [*found.fitting["modular"]] == ["rss", "none"]
    assert "settings tuned for it" in found.fitting["modular"]["rss"]
    assert found.content({})["fitting"] == found.fitting
