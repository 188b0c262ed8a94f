"""``roadmend faults``: one disturbed run of the real graph, judged, and kept."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import click
import pytest

from roadmend.cli import faults as command
from roadmend.cli.main import cli, main
from roadmend.core.journal import Key
from roadmend.core.resources import config_folder
from roadmend.faults import staging
from roadmend.faults.campaign import FaultCampaign
from roadmend.faults.evidence import Evidence
from roadmend.faults.fault import MethodFault, SignalFault
from roadmend.faults.file_kinds import FILES
from roadmend.faults.files import FileCampaign
from roadmend.faults.processes import left_of
from roadmend.faults.trial import Disturbed
from roadmend.nodes.graph_options import NODES

KILLED = SignalFault(name="killed", node="policy", signal="KILL")
CAMPAIGN = """
repair: rss
families: [S3]
seeds: 1
clocks: [lockstep]
earliest: 0.5
latest: 1.0
signals:
  - {name: policy killed, node: policy, signal: KILL, declared: STALE_COMMAND, exits: [1]}
topics:
  - {name: no number, topic: policy/command, distortion: nan, declared: INVALID_COMMAND}
files: {kinds: [corpus, search settings], damages: [truncated, endless], flips: 1}
"""


@pytest.mark.graph
def test_a_killed_policy_is_safe_and_reported_and_what_was_run_is_not_run_again(tmp_path, capsys, monkeypatch):
    file = tmp_path / "campaign.yaml"
    file.write_text(CAMPAIGN)
    arguments = ["faults", "--config", str(file), "--out", str(tmp_path / "out"), "--page"]
    code = main([*arguments, "--json"])
    out, err = capsys.readouterr()
    told = json.loads(out)
    # On a busy machine the drive may be over before the signal is sent: that row then has no run, which is said.
    assert code == told["too_late"], err
    bare, killed, distorted, *files = told["rows"]
    assert (bare["runs"], bare["safe"]) == (1, 1)
    assert killed["runs"] + told["too_late"] == 1
    assert ("policy killed, lockstep x 1: the fault came too late in 1 of 1 runs" in err) == told["too_late"]
    assert killed["safe"] == killed["reported"] == killed["runs"]
    assert distorted["safe"] == distorted["reported"] == distorted["within_3_ticks"] == 1
    assert [(row["fault"], row["safe"]) for row in files] == [
        ("corpus: truncated", 1),
        ("corpus: endless", 1),
        ("search settings: truncated", 1),
        ("search settings: endless", 1),
    ]
    monkeypatch.setattr(command, "disturb", None)
    monkeypatch.setattr(command, "FileBench", lambda: None)
    assert main(arguments) == code
    assert "policy killed" in capsys.readouterr().out
    for name in ("faults.md", "faults.html"):
        assert "policy killed" in (tmp_path / "out" / name).read_text()


def test_a_row_that_there_is_not_is_named_with_those_that_are(tmp_path, capsys):
    assert main(["faults", "--fault", "all", "--out", str(tmp_path / "out")]) == 2
    assert "choose of policy killed" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_runs_at_once_are_told_in_the_order_of_their_rows(tmp_path, capsys, monkeypatch):
    file = tmp_path / "campaign.yaml"
    file.write_text(CAMPAIGN[: CAMPAIGN.index("files")].replace("seeds: 1", "seeds: 4"))
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    both, under_way, most = threading.Barrier(2, timeout=30), [], []
    domains = set()

    def pretended(campaign, trial, graph):
        domains.add(graph["ROS_DOMAIN_ID"])
        under_way.append(trial)
        both.wait()  # nobody gets on alone
        most.append(len(under_way))
        under_way.remove(trial)
        driven = Evidence(
            161, 0, is_declared=True, silence=None, to_state=None, to_standstill=None, in_diagnostics=True, begun=0.0
        )
        return Disturbed(True, 1 if trial.fault else 0, "TIMEOUT", 3.0, True, False, (), True, False, driven, ())

    monkeypatch.setattr(command, "disturb", pretended)
    assert main(["faults", "--config", str(file), "--out", str(tmp_path / "out"), "--parallel", "2", "--json"]) == 1
    told = json.loads(capsys.readouterr().out)
    assert max(most) == 2
    assert "7" not in domains
    assert len(domains) > 1
    names = [run["fault"] for run in told["runs"]]
    assert names == [None, "policy killed", "no number"] * 4
    assert [run["seed"] for run in told["runs"]] == [0, 0, 0, 1, 1, 1, 2, 2, 2, 3, 3, 3]
    assert [(row["fault"], row["runs"]) for row in told["rows"]] == [(name or "no fault", 4) for name in names[:3]]
    assert told["provenance"]["command"].endswith("--parallel 2")


def test_a_run_goes_by_the_models_that_it_is_made_with(monkeypatch, tmp_path):
    campaign = FaultCampaign(signals=(KILLED,), methods=(MethodFault(name="cut", method="cut", exits=(2,)),))
    before = command._run_keys(campaign)
    with monkeypatch.context() as other:
        other.setattr(command, "driver_key", lambda *names: Key(f"another model of {names}"))
        after = command._run_keys(campaign)
        assert not {*before.values()} & {*after.values()}
    (tmp_path / "models").mkdir()
    for file in (config_folder() / "models").glob("*-modular.safetensors"):
        (tmp_path / "models" / file.name).write_bytes(file.read_bytes() + b"1")
    monkeypatch.setattr(staging, "config_folder", lambda: tmp_path)
    changed = {trial.row for trial, key in command._run_keys(campaign).items() if key != before[trial]}
    assert changed == {"cut"}


def test_the_code_of_every_node_and_of_every_command_that_is_given_a_file_counts():
    assert {f"roadmend.nodes.{entry.node}" for entry in NODES} - {"roadmend.nodes.foxglove"} < {*command._CODE}
    for kind in FILES.values():
        for words in filter(None, (kind.read, *kind.made)):
            found, names = cli, [*words]
            while isinstance(found, click.Group):
                found = found.get_command(click.Context(found), names.pop(0))
            assert found.callback.__module__ in command._FILE_CODE


def test_a_file_goes_by_what_drives_in_the_commands(monkeypatch):
    campaign = FaultCampaign(files=FileCampaign(kinds=("corpus",)))
    before = command._file_keys(campaign)
    monkeypatch.setattr(command, "driver_key", lambda *names: Key(f"another model of {names}"))
    after = command._file_keys(campaign)
    assert before.keys() == after.keys()
    assert not {*before.values()} & {*after.values()}


@pytest.mark.parametrize(("late", "code"), [({0}, 0), ({0, 1}, 1)])
def test_faults_that_came_too_late_are_told_and_a_row_of_them_alone_is_none(tmp_path, capsys, monkeypatch, late, code):
    file = tmp_path / "campaign.yaml"
    file.write_text(CAMPAIGN[: CAMPAIGN.index("topics")].replace("seeds: 1", "seeds: 2"))

    def pretended(_campaign, trial, _graph):
        injected = trial.fault is None or trial.seed not in late
        driven = Evidence(161, 0, is_declared=True)
        said = 1 if trial.fault and injected else 0
        return Disturbed(injected, said, "TIMEOUT", 3.0, True, False, (), True, False, driven, ())

    monkeypatch.setattr(command, "disturb", pretended)
    assert main(["faults", "--config", str(file), "--out", str(tmp_path / "out"), "--json"]) == code
    out, err = capsys.readouterr()
    assert json.loads(out)["too_late"] == len(late)
    assert err == f"policy killed, lockstep x 1: the fault came too late in {len(late)} of 2 runs\n"


@pytest.fixture
def short_folder():
    """A folder whose path is short enough for sockets below those of runs."""
    with tempfile.TemporaryDirectory(prefix="faults-", dir="/tmp") as name:
        yield Path(name)


def test_a_termination_ends_the_runs_under_way_as_an_interrupt_does(tmp_path, monkeypatch, capsys):
    file, started = tmp_path / "campaign.yaml", []
    file.write_text(CAMPAIGN[: CAMPAIGN.index("files")])

    def pretended(_campaign, _trial, graph):
        words = [sys.executable, "-c", "import time; time.sleep(20)"]
        started.append(subprocess.Popen(words, env={**os.environ, **graph}))
        os.kill(os.getpid(), signal.SIGTERM)
        started[-1].wait()

    monkeypatch.setattr(command, "disturb", pretended)
    before = signal.signal(signal.SIGTERM, signal.SIG_IGN)
    try:
        assert main(["faults", "--config", str(file), "--out", str(tmp_path / "out")]) == 130
        assert signal.getsignal(signal.SIGTERM) == signal.SIG_IGN
    finally:
        signal.signal(signal.SIGTERM, before)
    assert [child.returncode for child in started] == [-signal.SIGKILL]
    assert "interrupted; what is finished is kept" in capsys.readouterr().err


@pytest.mark.graph
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_runs_under_way(short_folder, number):
    tmp_path = short_folder
    file, out = tmp_path / "campaign.yaml", tmp_path / "out"
    file.write_text(CAMPAIGN.replace("seeds: 1", "seeds: 2").replace("[lockstep]", "[realtime]"))
    words = ["faults", "--config", str(file), "--rate", "0.05", "--out", str(out), "--parallel", "2"]
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    running = subprocess.Popen([sys.executable, "-m", "roadmend.cli", *words], env=environment, stderr=subprocess.PIPE)
    until = time.monotonic() + 120
    while len([*tmp_path.glob("roadmend-faults-*/tmp/roadmend-run-*/sim.driving")]) < 2:
        assert running.poll() is None
        assert time.monotonic() < until
        time.sleep(0.05)
    running.send_signal(number)
    said = running.communicate(timeout=60)[1].decode()
    assert running.returncode == 130, said
    assert "Traceback" not in said
    assert left_of(f"TMPDIR={tmp_path}") == []
    assert not [*tmp_path.glob("roadmend-faults-*")]
