"""Damaged files: each damage is one, and what a command made of it is judged against the sound file."""

import dataclasses
import os
import stat
import tracemalloc

import pytest

from roadmend.core.errors import InputError
from roadmend.faults.damage import BIG, DAMAGES
from roadmend.faults.files import FileBench, FileCampaign, FileTrial, Refused, file_trials
from roadmend.faults.refusal import FILE_HEADING, file_table, refusal_rows
from roadmend.recording.info import bag_info

SOUND = Refused(0, 0, traceback=False, seconds=2.0, memory=300 << 10, is_tree_whole=True)
GOOD = dataclasses.replace(SOUND, exit_code=2, lines=1, stderr=("roadmend: f: is cut; mend it",))


@pytest.mark.parametrize("name", DAMAGES)
@pytest.mark.parametrize("sound", [b"a: 1\n" * 200, b"<net></net>" * 50, b"\x00\x01" * 300, b"\x89MCAP0\r\n" * 40])
def test_each_damage_is_another_file_than_the_sound_one(name, sound, tmp_path):
    DAMAGES[name](tmp_path / "f", sound, 1)
    state = (tmp_path / "f").lstat()
    if stat.S_ISREG(state.st_mode) and state.st_size < BIG:
        assert (tmp_path / "f").read_bytes() != sound
        assert state.st_size < 4 << 20


def test_damage_is_the_same_with_the_same_seed(tmp_path):
    for name in ("truncated", "flipped", "foreign"):
        for place, seed in (("a", 1), ("b", 1), ("c", 2)):
            DAMAGES[name](tmp_path / f"{name}-{place}", bytes(range(256)) * 4, seed)
        one, same, other = ((tmp_path / f"{name}-{place}").read_bytes() for place in "abc")
        assert one == same != other


def test_the_bag_of_the_bomb_is_one_that_a_reader_begins_to_unpack(tmp_path):
    DAMAGES["bomb"](tmp_path / "f.mcap", b"\x89MCAP0\r\n", 0)
    with pytest.raises(InputError, match=r"times|ratio|more than"):
        bag_info(tmp_path / "f.mcap")


@pytest.mark.parametrize("sound", [b"<net></net>", b"\x89MCAP0\r\n"])
def test_a_bomb_is_made_of_pieces(sound, tmp_path):
    tracemalloc.start()
    try:
        DAMAGES["bomb"](tmp_path / "f", sound, 0)
        assert tracemalloc.get_traced_memory()[1] < 8 << 20
    finally:
        tracemalloc.stop()


def test_every_kind_begins_with_its_sound_file():
    trials = file_trials(FileCampaign(kinds=("corpus", "bag"), damages=("flipped", "endless"), flips=2))
    assert trials == [
        FileTrial(kind, damage, seed)
        for kind in ("corpus", "bag")
        for damage, seed in (("", 0), ("flipped", 0), ("flipped", 1), ("endless", 0))
    ]


def judged(damage="endless", kind="corpus", **changes):
    (row,) = refusal_rows(
        [(FileTrial(kind, ""), SOUND), (FileTrial(kind, damage), dataclasses.replace(GOOD, **changes))]
    )
    return row["faults"]


def test_a_refusal_in_a_line_is_right():
    assert judged() == []
    assert judged("flipped", exit_code=0, lines=0) == []


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"exit_code": None}, "hung"),
        ({"exit_code": 0}, "exit code 0"),
        ({"lines": 2}, "2 lines in place of one"),
        ({"traceback": True}, "a bare traceback"),
        ({"seconds": 13.0}, "took 13 s"),
        ({"memory": 900 << 10}, "took 900 MB"),
        ({"is_tree_whole": False}, "changed what it does not own, or left something"),
    ],
)
def test_each_of_these_is_not(changes, fault):
    assert judged(**changes) == [fault]


def test_where_the_sound_file_is_refused_no_damaged_one_can_fail_which_is_a_fault():
    refused = dataclasses.replace(GOOD, exit_code=2)
    (row,) = refusal_rows([(FileTrial("corpus", ""), refused), (FileTrial("corpus", "endless"), GOOD)])
    assert (row["safe"], row["faults"]) == (0, ["the sound file is refused"])


@pytest.mark.graph
@pytest.mark.parametrize("kind", ["SUMO configuration", "crash scenario", "bag's metadata"])
def test_a_sound_file_is_read_with_what_lies_beside_it(kind):  # those of the other kinds, in every campaign
    refused = FileBench().give(FileTrial(kind, ""))
    assert (refused.exit_code, refused.is_tree_whole) == (0, True), refused.stderr


def test_a_command_is_given_the_file_and_its_tree_is_looked_at(tmp_path, monkeypatch):
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    refused = FileBench().give(FileTrial("corpus", "pipe"))
    assert (refused.exit_code, refused.lines, refused.traceback, refused.is_tree_whole) == (2, 1, False, True)
    assert refused.memory > 20 << 10
    rows = refusal_rows([(FileTrial("corpus", ""), SOUND), (FileTrial("corpus", "pipe"), refused)])
    assert all(len(line) == len(FILE_HEADING) for line in file_table(rows))
    assert Refused.parse(refused.as_dict()) == refused
    assert not [*os.scandir(tmp_path)]


def test_what_a_command_took_is_not_what_its_caller_has_had():
    bench, trial = FileBench(), FileTrial("corpus", "pipe")
    alone = bench.give(trial).memory
    much = bytearray(alone + (200 << 10) << 10)
    much[::4096] = b"x" * len(much[::4096])
    assert abs(bench.give(trial).memory - alone) < 50 << 10
