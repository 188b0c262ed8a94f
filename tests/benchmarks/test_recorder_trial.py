"""The recorder under load in small: what ``bench recorder`` measures at length."""

import json

import pytest

from bench import main
from harness import bench_recorder
from harness.recorder_trial import Killed, Load, Recorded, kill, moments, record
from roadmend.core.errors import RoadmendError

pytestmark = pytest.mark.graph


@pytest.mark.parametrize("rate", [0.0, 1000.0])
def test_nothing_of_a_load_is_dropped(tmp_path, rate):
    recorded = record(tmp_path, Load(2000, rate))
    assert (recorded.published, recorded.recorded, recorded.dropped) == (2000, 2000, 0)
    assert recorded.disk_bytes > 2000 * 20_000  # random bytes do not get smaller
    assert recorded.megabytes_per_second > 0


@pytest.mark.parametrize("after", [0.7, 1.3])
def test_a_kill_under_load_leaves_all_but_the_last_second(tmp_path, after):
    killed = kill(tmp_path, Load(100_000, 2000.0), after)
    assert killed.recovered > 0
    assert killed.holes == 0
    assert 0 <= killed.lost_seconds < 1.0


def test_moments_are_random_and_repeatable():
    assert moments(20) == moments(20)
    assert len(set(moments(20))) == 20
    assert all(0.5 <= moment <= 3.0 for moment in moments(100))


def test_a_load_that_nobody_records_is_an_error(tmp_path):
    (tmp_path / "bag").mkdir()  # in the recorder's place
    with pytest.raises(RoadmendError, match="nobody records the load"):
        record(tmp_path, Load(10))


def test_the_command_writes_its_figures(tmp_path, monkeypatch, capsys):
    rates = iter([40.0, 60.0, 42.0, 80.0])
    monkeypatch.setattr(bench_recorder, "_bare", lambda *_: 100.0)
    monkeypatch.setattr(bench_recorder, "record", lambda *_: Recorded(100, 99, 2000.0, 1.0, round(next(rates) * 1e6)))
    monkeypatch.setattr(bench_recorder, "kill", lambda *_: Killed(10, 1, 0.25))
    assert main(["recorder", "--repeats", "2", "--kills", "3", "--out", str(tmp_path)]) == 0
    assert "0.70 x" in capsys.readouterr().out
    content = json.loads((tmp_path / "recorder.json").read_text())
    assert content["ratio_to_bare"] == {"median": 0.7, "min": 0.6, "max": 0.8}
    assert (content["paced"]["dropped"], content["paced"]["published"]) == (2, 200)
    assert content["killed"]["holes"] == content["killed"]["recordings"] == 3
    assert "3 of 3 bags recovered, 3 messages missing before" in (tmp_path / "recorder.md").read_text()
