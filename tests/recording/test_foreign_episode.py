"""A bag of another stack as an episode, and drawn."""

import json

import pytest

from roadmend.cli.main import main
from roadmend.core.command import Command
from roadmend.core.errors import InputError
from roadmend.core.repair import Repair, RepairStatus
from roadmend.recording.foreign_episode import read_foreign_episode
from roadmend.recording.foreign_objects import EgoOutline

from .foreign_messages import record

CAR = EgoOutline(4.0, 1.7, 1.0)
PLACES = ["--ego", "/odom", "--objects", "/detections"]


def answer(step):
    """It brakes from 3 s on."""
    brakes = step >= 300
    status = RepairStatus.REPAIRED if brakes else RepairStatus.PASS
    action = -1.0 if brakes else 0.2
    return Repair(Command.from_action(action), status, 0.9, 0.5, 0.2, action, brakes, reason="one who stands" * brakes)


def test_without_answers_each_odometry_is_a_tick(tmp_path):
    episode = read_foreign_episode(record(tmp_path / "bag"), "/odom", "/detections", CAR)
    assert len(episode.ego) == 250
    assert episode.repairs == {}
    stamp = 102_000_000_000
    ego = episode.ego[stamp]
    assert (ego.x, ego.speed, ego.length, ego.width) == (pytest.approx(21.0), 10.0, 4.0, 1.7)  # its centre is 1 m ahead
    assert episode.objects[stamp].x[0] == pytest.approx(60.0, abs=1.5)  # on the map, not from the ego
    assert episode.objects[stamp].id.tolist() == [7]


def test_with_answers_each_of_them_is_a_tick_and_its_interventions_are_spells(tmp_path):
    episode = read_foreign_episode(record(tmp_path / "bag", repaired=answer), "/odom", "/detections", CAR)
    assert len(episode.ego) == len(episode.repairs) == 100
    (spell,) = episode.spells()
    assert (spell.spell.begin, spell.why) == (pytest.approx(103.0), "one who stands")
    assert episode.lanes is None
    assert episode.route is None


@pytest.mark.parametrize(
    ("ego", "objects", "message"),
    [
        ("/odm", "/detections", r"--ego /odm: is not in .*; did you mean /odom\?"),
        ("", "/detections", "--ego: is not given; name one of /odom"),
        ("/odom", "/drive/accel", "--objects /drive/accel: is geometry_msgs/msg/AccelStamped, not "),
        ("/odom", "", "--objects: is not given; name one of /detections"),
    ],
)
def test_what_is_not_there_is_named_with_what_is(tmp_path, ego, objects, message):
    with pytest.raises(InputError, match=message):
        read_foreign_episode(record(tmp_path / "bag"), ego, objects, CAR)


@pytest.mark.parametrize("name", ["drive.png", "drive.html"])
def test_it_is_drawn(tmp_path, capsys, name):
    bag = record(tmp_path / "bag", repaired=answer)
    assert main(["bag", "plot", str(bag), *PLACES, "--out", str(tmp_path / name), "--json"]) == 0
    assert 103.0 < json.loads(capsys.readouterr().out)["time"] < 105.0  # in the middle of the intervention
    assert (tmp_path / name).stat().st_size > 20_000
    if name.endswith("html"):
        assert "one who stands" in (tmp_path / name).read_text()


def test_futures_are_refused_and_the_way_is_told(tmp_path, capsys):
    bag = record(tmp_path / "bag")
    assert main(["bag", "plot", str(bag), *PLACES, "--futures", "3", "--out", str(tmp_path / "a.png")]) == 2
    assert "another stack's drive cannot be driven again" in capsys.readouterr().err
    assert main(["bag", "plot", str(bag), "--out", str(tmp_path / "a.png")]) == 2
    assert "or name the topics of another stack's bag with --ego and --objects" in capsys.readouterr().err
    assert not (tmp_path / "a.png").exists()
