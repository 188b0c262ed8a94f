"""Controls: what is counted, and that finished work is kept."""

import json
from dataclasses import replace

import pytest

from harness import bench_controls, control_jobs
from harness.bench_controls import bound_figures, controls, shuffle_figures
from harness.control_jobs import ControlJob, ControlResult
from roadmend.cli.main import run_group
from roadmend.world.corpus import corpus_of


def result(case, *, violation=True, worth=1.0, shuffled=0.0, speed=8.0, **more):
    return ControlResult(case, "S1", violation, speed if violation else None, worth, shuffled, 0.5, 0.4, **more)


def test_a_method_that_is_no_better_than_its_shuffle_has_no_lead():
    same = [result(f"v{n}", worth=float(n % 2), shuffled=float(n % 2)) for n in range(20)]
    same += [result(f"s{n}", violation=False, worth=0.0) for n in range(20)]
    figures = shuffle_figures(same)
    assert figures["delta_e"] == figures["shuffled_delta_e"] == 50.0
    assert figures["more_than_shuffled"] == 0.0
    assert figures["interval"] == [0.0, 0.0]


def test_timing_that_matters_shows_and_impact_speeds_are_told_apart():
    found = [result(f"v{n}", shuffled=0.25, in_futures=0.8) for n in range(10)]
    found += [result(f"t{n}", worth=0.0, speed=1.0, in_futures=0.0) for n in range(10)]
    found += [result(f"s{n}", violation=False, worth=float(n == 0)) for n in range(10)]
    figures = shuffle_figures(found)
    assert (figures["delta_e"], figures["shuffled_delta_e"]) == (40.0, 12.5)
    assert figures["more_than_shuffled"] == pytest.approx(27.5)
    assert figures["interval"][0] < 27.5 < figures["interval"][1]
    assert (figures["in_futures"], figures["fix_hard"], figures["fix_touches"]) == (pytest.approx(40.0), 100.0, 0.0)
    assert (figures["hard"], figures["touches"]) == (10, 10)
    assert (figures["dose_violations"], figures["shuffled_dose_violations"]) == (0.5, pytest.approx(0.4))


def test_the_bound_counts_what_a_pulse_repairs():
    found = [result("a", bound=0.5, bound_in_futures=0.9), result("b", worth=0.0)]
    figures = bound_figures(found)
    assert figures["adreft_dose"] is None
    assert (figures["violations"], figures["repaired"], figures["dose"], figures["in_futures"]) == (2, 1, 0.5, 90.0)


def test_adreft_is_held_against_the_bound_in_the_cases_that_it_repairs():
    found = [result("a", bound=0.5, bound_in_futures=0.9), result("b", worth=0.0)]
    own = [replace(result("a"), dose=1.5), replace(result("b"), dose=9.0), result("c", violation=False)]
    assert bound_figures(found, own)["adreft_dose"] == 1.5


def test_the_dose_of_a_pulse_is_what_it_takes_from_the_policy():
    """Not what it would take from one at full throttle throughout: policies brake and coast."""
    case = min(corpus_of("modular").select("S3", "validation", violation=True), key=lambda case: case.duration)
    found = control_jobs.control(ControlJob(case, "modular", None))
    nominal = {(1.0 - action) * duration for duration, action in control_jobs._PULSES}
    assert found.bound is not None
    assert 0.0 < found.bound < max(nominal)
    assert all(found.bound != pytest.approx(dose) for dose in nominal)


def test_what_a_corpus_that_was_renewed_says_otherwise_is_driven_anew():
    case = corpus_of("modular").select("S3", "validation", violation=True)[0]
    keys = {
        ControlJob(case, "modular", None).key,
        ControlJob(replace(case, duration=case.duration + 0.05), "modular", None).key,
        ControlJob(replace(case, impact_speed=case.impact_speed + 0.1), "modular", None).key,
    }
    assert len(keys) == 3


@pytest.mark.slow
def test_a_run_gives_json_and_tables_and_the_next_one_drives_nothing(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(bench_controls, "FAMILIES", ("S5",))
    words = ["--policy", "modular", "--methods", "adreft", "--cases", "1", "--workers", "1"]
    words += ["--work", str(tmp_path / "work"), "--out", str(tmp_path / "out"), "--json"]
    assert run_group(controls, "controls", words) == 0
    content = json.loads(capsys.readouterr().out)
    figures = content["controls"]["modular"]["shuffled"]["adreft"]
    assert (figures["violations"], figures["successes"]) == (1, 1)
    assert len(figures["contender"]["model"]["digest"]) == 64
    assert content["bound"]["modular"]["informed"]["violations"] == 1
    assert json.loads((tmp_path / "out" / "adreft-controls.json").read_text()) == content
    assert "Informed bound" in (tmp_path / "out" / "adreft-controls.md").read_text()
    monkeypatch.setattr(control_jobs, "control", lambda _job: pytest.fail("was driven again"))
    assert run_group(controls, "controls", words) == 0


def test_a_method_that_there_is_not_is_refused_before_anything_is_driven(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(bench_controls, "run_controls", lambda *_: pytest.fail("was driven"))
    words = ["--methods", "rule, rsss", "--work", str(tmp_path / "work")]
    assert run_group(controls, "controls", words) == 2
    assert "--methods: there is no 'rsss'; choose from none, random_paper" in capsys.readouterr().err


def test_methods_may_be_separated_by_commas_and_spaces(tmp_path, capsys, monkeypatch):
    asked = []
    monkeypatch.setattr(bench_controls, "resolve", lambda *given: asked.append(given[-1]) or ([], []))
    words = ["--policy", "modular", "--methods", "rule, rss", "--no-bound", "--workers", "1"]
    assert run_group(controls, "controls", [*words, "--work", str(tmp_path / "work"), "--json"]) == 0
    assert asked == [["rule", "rss"]]
    assert " --methods rule,rss " in json.loads(capsys.readouterr().out)["provenance"]["command"]
