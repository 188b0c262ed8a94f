"""Campaigns: what a file may say, and the runs that it stands for."""

from pathlib import Path

import pytest

from roadmend.core.errors import InputError
from roadmend.core.repair import RepairStatus
from roadmend.core.resources import config_folder
from roadmend.faults.campaign import BARE, FaultCampaign, load_campaign, trials_of
from roadmend.faults.fault import SignalFault
from roadmend.faults.file_kinds import FILES

KILLED = {"name": "killed", "node": "policy", "signal": "KILL"}


def written(folder: Path, text: str) -> Path:
    path = folder / "campaign.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_campaign_that_comes_with_the_package_names_every_node_that_a_run_cannot_do_without():
    campaign = load_campaign(config_folder() / "faults" / "campaign.yaml")
    assert {fault.node for fault in campaign.signals} >= {"sim", "policy", "repair", "recorder"}
    assert {fault.signal for fault in campaign.signals} == {"KILL", "STOP"}


def test_it_has_rows_for_every_state_that_the_repair_node_can_declare():
    campaign = load_campaign(config_folder() / "faults" / "campaign.yaml")
    quiet = {RepairStatus.PASS, RepairStatus.REPAIRED, RepairStatus.STARTING}
    assert {fault.declared for fault in campaign.faults} >= {status.name for status in {*RepairStatus} - quiet}
    assert campaign.files.kinds == tuple(FILES)


def test_rows_that_are_chosen_are_left_alone():
    campaign = load_campaign(config_folder() / "faults" / "campaign.yaml")
    chosen = campaign.only(["both pedals", "files"])
    assert [fault.name for fault in chosen.faults] == ["both pedals"]
    assert chosen.files == campaign.files
    assert campaign.only(["both pedals"]).files is None


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("signals: []", "at least 1"),
        ("signals: [{name: a, node: policy, signal: KLL}]", "signal"),
        ("signals: [{name: a, node: polcy, signal: KILL}]", "node"),
        ("signals: [{name: a, node: policy, signal: KILL, resume: 1.0}]", "only who was stopped can go on"),
        ("signals: [{name: a, node: policy, signal: KILL, declared: STALE}]", "none of PASS"),
        ("signals: [{name: no fault, node: policy, signal: KILL}]", "one named 'no fault'"),
        ("signals: [{name: a, node: sim, signal: KILL}, {name: a, node: sim, signal: STOP}]", "two of one name"),
        ("signals: [{name: a, node: sim, signal: KILL, at: 1}]", "at"),
        ("topics: [{name: a, topic: ego, distortion: both_pedals}]", "none of those of ego"),
        ("topics: [{name: a, topic: ego, distortion: late}]", "late: is of the distortion 'late'"),
        ("topics: [{name: a, topic: ego, distortion: nan, shift: 1.0}]", "shift of 'jump'"),
        ("topics: [{name: a, topic: ego, distortion: nan, share: 0.0}]", "share"),
        ("topics: [{name: a, topic: ego, distortion: nan}]", "give declared or says, or named: false"),
        ("signals: [{name: a, node: policy, signal: KILL}]\nrates: [0]", "rates"),
        ("signals: [{name: a, node: policy, signal: KILL}]\nrates: [1.0, 101.0]", "rates"),
        ("signals: [{name: a, node: policy, signal: KILL}]\nrates: [.nan]", "rates"),
        ("methods: [{name: a, method: sleeps}]", "method"),
        ("files: {kinds: [scenarios]}", "none of scenario"),
        ("files: {damages: [bent]}", "none of truncated"),
    ],
)
def test_what_no_campaign_can_be_is_refused_in_one_line(tmp_path, text, what):
    with pytest.raises(InputError) as caught:
        load_campaign(written(tmp_path, text))
    assert what in str(caught.value)
    assert "\n" not in str(caught.value)


def test_with_each_seed_every_row_is_run_on_every_clock_and_the_undisturbed_one_first():
    campaign = FaultCampaign(signals=(SignalFault(**KILLED),), seeds=2, rates=(1.0, 5.0))
    places = [(trial.row, trial.clock, trial.rate, trial.seed) for trial in trials_of(campaign)]
    assert places == [
        (row, clock, rate, seed)
        for seed in (0, 1)
        for row in (BARE, "killed")
        for clock, rate in (("lockstep", 1.0), ("realtime", 1.0), ("realtime", 5.0))
    ]


def test_with_one_rate_every_row_is_run_at_one_of_them_and_the_undisturbed_one_at_all():
    rows = tuple(SignalFault(**KILLED | {"name": str(number)}) for number in range(3))
    campaign = FaultCampaign(signals=rows, seeds=1, clocks=("realtime",), rates=(1.0, 5.0), one_rate=True)
    assert [(trial.row, trial.rate) for trial in trials_of(campaign)] == [
        (BARE, 1.0),
        (BARE, 5.0),
        ("0", 1.0),
        ("1", 5.0),
        ("2", 1.0),
    ]
    assert [(trial.row, trial.rate) for trial in trials_of(campaign.only(["1"]))][-1] == ("1", 5.0)
