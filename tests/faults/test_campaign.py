"""Campaigns: what a file may say, and the runs that it stands for."""

from pathlib import Path

import pytest

from roadmend.core.errors import InputError
from roadmend.core.resources import config_folder
from roadmend.faults.campaign import BARE, Fault, FaultCampaign, load_campaign, trials_of

KILLED = {"name": "killed", "node": "policy", "signal": "KILL"}


def written(folder: Path, text: str) -> Path:
    path = folder / "campaign.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_campaign_that_comes_with_the_package_names_every_node_that_a_run_cannot_do_without():
    campaign = load_campaign(config_folder() / "faults" / "campaign.yaml")
    assert {fault.node for fault in campaign.faults} >= {"sim", "policy", "repair", "recorder"}
    assert {fault.signal for fault in campaign.faults} == {"KILL", "STOP"}


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("faults: []", "at least 1"),
        ("faults: [{name: a, node: policy, signal: KLL}]", "signal"),
        ("faults: [{name: a, node: polcy, signal: KILL}]", "node"),
        ("faults: [{name: a, node: policy, signal: KILL, resume: 1.0}]", "only who was stopped can go on"),
        ("faults: [{name: a, node: policy, signal: KILL, declared: STALE}]", "none of STALE_COMMAND"),
        ("faults: [{name: no fault, node: policy, signal: KILL}]", "one named 'no fault'"),
        ("faults: [{name: a, node: sim, signal: KILL}, {name: a, node: sim, signal: STOP}]", "two of one name"),
        ("faults: [{name: a, node: sim, signal: KILL, at: 1}]", "at"),
    ],
)
def test_what_no_campaign_can_be_is_refused_in_one_line(tmp_path, text, what):
    with pytest.raises(InputError) as caught:
        load_campaign(written(tmp_path, text))
    assert what in str(caught.value)
    assert "\n" not in str(caught.value)


def test_every_row_is_run_on_every_clock_and_the_undisturbed_one_first():
    campaign = FaultCampaign(faults=(Fault(**KILLED),), seeds=2, rates=(1.0, 5.0))
    places = [(trial.row, trial.clock, trial.rate, trial.seed) for trial in trials_of(campaign)]
    assert places == [
        (row, clock, rate, seed)
        for row in (BARE, "killed")
        for clock, rate in (("lockstep", 1.0), ("realtime", 1.0), ("realtime", 5.0))
        for seed in (0, 1)
    ]
