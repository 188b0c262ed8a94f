"""Selections on disk."""

import hashlib
import json

import pytest

from roadmend.core.errors import InputError
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.describe import entry_of
from roadmend.sera.recommendation import Selection, read_selection, scenarios_of
from roadmend.world.families import sample_scenario

SCENARIOS = [sample_scenario("S1", seed) for seed in (1, 2)]


@pytest.fixture
def bank(tmp_path):
    path = tmp_path / "small.bank"
    entries = [entry_of(scenario, "test") for scenario in SCENARIOS]
    described = entries[1].__class__("f" * 64, "only words", "test", entries[1].descriptor)
    build_bank(path, [*entries, described])
    with Bank(path) as opened:
        yield opened


def selection(*digests):
    return Selection(tuple(digests), "")


def test_a_selection_is_read_each_scenario_once_and_found_in_its_bank(tmp_path, bank):
    path = tmp_path / "selection.json"
    picks = [{"digest": scenario.digest, "name": "x"} for scenario in (*SCENARIOS[::-1], SCENARIOS[0])]
    path.write_text(json.dumps({"refined": picks, "initial": []}))
    found = read_selection(path, "refined")
    assert found.digest == hashlib.sha256(path.read_bytes()).hexdigest()
    assert scenarios_of(found, bank) == SCENARIOS[::-1]
    with pytest.raises(InputError, match="selects nothing at the 'initial' stage"):
        read_selection(path, "initial")
    with pytest.raises(InputError, match="no selection with a 'random' stage"):
        read_selection(path, "random")


@pytest.mark.parametrize("text", ["", "[]", '{"refined": [{"name": "x"}]}', None])
def test_what_is_no_selection_is_refused(tmp_path, text):
    path = tmp_path / "selection.json"
    if text is not None:
        path.write_text(text)
    with pytest.raises(InputError, match=r"selection\.json"):
        read_selection(path, "refined")


def test_a_scenario_that_is_not_in_the_bank_or_only_described_is_refused(bank):
    with pytest.raises(InputError, match="holds no scenario 000000000000"):
        scenarios_of(selection("0" * 64), bank)
    with pytest.raises(InputError, match="only describes only words"):
        scenarios_of(selection("f" * 64), bank)
