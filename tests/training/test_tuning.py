"""Tuning: the two rounds, the choice, and going on after an interruption."""

from functools import partial

import pytest

from roadmend.core.errors import InputError
from roadmend.core.journal import Journal
from roadmend.measures.case_result import CaseResult
from roadmend.repair.registry import METHODS, make_repairer
from roadmend.training import tuning
from roadmend.training.tuning import EPISODES, FINALISTS, Tuning, part_of
from roadmend.training.tuning_grid import Rival, rivals_of
from tests.measures.results import episode

from .cases import Drawn, OnMap

CASES = [Drawn(family, seed, seed % 2 == 0) for family in ("S1", "S2") for seed in range(12)]
GRID = tuple({"probability": value / 10.0} for value in range(7))


def drive(driven, question, *, policy, method):
    """More probability repairs more, up to 0.5; 0.6 degrades; 0.5 is the rougher twin of 0.4."""
    parameters, case = question
    driven.append((parameters["probability"], case.name))
    value = parameters["probability"]
    collided = case.seed / 24.0 > min(value, 0.4) if case.is_violation else value > 0.55
    outcome = "COLLISION" if collided else "GOAL"
    return CaseResult(case.name, case.family, case.is_violation, episode(outcome, 100, 10, 10 * value))


@pytest.fixture
def driven(monkeypatch):
    driven = []
    monkeypatch.setattr(tuning, "_evaluate", partial(drive, driven))
    return driven


def tune(path, driven, cases=CASES, **identity):
    with Journal(path, EPISODES, {"corpus": "abc", **identity}) as journal:
        return Tuning(cases, "modular", journal, map).tune(Rival("r", "random", GRID))


def test_on_a_map_that_has_changed_all_is_driven_anew(tmp_path, driven):
    cases = [OnMap(case.family, case.seed, case.is_violation, path=tmp_path / "own.net.xml") for case in CASES]
    numbers = []
    for content in ("<net/>", "<net/>", "<net></net>"):
        (tmp_path / "own.net.xml").write_text(content)
        tune(tmp_path / "a.jsonl", driven, cases)
        numbers.append(len(driven))
    assert 0 < numbers[0] == numbers[1] == numbers[2] / 2


def test_the_best_is_chosen_and_of_equals_the_gentlest(tmp_path, driven):
    tuned = tune(tmp_path / "a.jsonl", driven)
    assert tuned.chosen.parameters == {"probability": 0.4}
    assert sum(point.is_finalist for point in tuned.points) == FINALISTS
    assert tuned.chosen.whole.delta_e == max(point.whole.delta_e for point in tuned.points if point.is_finalist)
    assert tuned.points[5].whole.delta_e == tuned.chosen.whole.delta_e
    assert tuned.dump()["parameters"] == {"probability": 0.4}
    assert len(tuned.dump()["grid"]) == len(GRID)


def test_no_pair_is_driven_twice_and_only_finalists_drive_everything(tmp_path, driven):
    tune(tmp_path / "a.jsonl", driven)
    part = len(part_of(CASES))
    assert len(driven) == len(set(driven)) == len(GRID) * part + FINALISTS * (len(CASES) - part)


def test_interrupted_work_goes_on(tmp_path, driven):
    path = tmp_path / "a.jsonl"
    whole = tune(path, driven).dump()
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:40]) + lines[40][:25])
    number = len(driven)
    driven.clear()
    assert tune(path, driven).dump() == whole
    assert len(driven) == number - 39
    assert path.read_bytes() == b"".join(lines)
    with pytest.raises(InputError, match="holds work with corpus 'abc', not 'abd'"):
        tune(path, driven, corpus="abd")
    path.write_bytes(b"".join([*lines[:3], b"{}\n"]))
    with pytest.raises(InputError, match="damaged"):
        tune(path, driven)


def test_the_part_holds_every_family_and_kind():
    part = part_of(CASES)
    assert {(case.family, case.is_violation) for case in part} == {(case.family, case.is_violation) for case in CASES}
    assert len(part) == 8
    assert part == [case for case in CASES if case in part]


def test_both_kinds_of_case_are_needed(tmp_path, driven):
    with pytest.raises(InputError, match="success"):
        tune(tmp_path / "a.jsonl", driven, [case for case in CASES if case.is_violation])


def test_every_setting_of_every_grid_is_one_of_the_method():
    for rival in rivals_of("modular"):
        assert len({str(values) for values in rival.grid}) == len(rival.grid) <= 24
        for values in rival.grid:
            if rival.method == "model":
                METHODS["model"].parameters(**values)
            else:
                make_repairer(rival.method, values)
