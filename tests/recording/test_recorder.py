"""The recorder as a process of its own, recording another process."""

import contextlib
import json
import re
import resource
import signal
import time
from pathlib import Path

import pytest
from mcap.exceptions import EndOfFile
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader
from rosbags.highlevel import AnyReader

from roadmend.recording.reader import BagReader
from roadmend.recording.recovery import recover

pytestmark = pytest.mark.graph

COUNT = 2000
TICK_NS = 50_000_000
STREAMS = ["/clock", "/ego", "/objects", "/policy/command", "/text", "/image"]


@pytest.fixture
def record(start, tmp_path):
    """Starts a recorder that writes tmp_path/bag."""

    def run(options=None, **parameters):
        values = {"output": tmp_path, "name": "bag", **parameters}
        pairs = [word for name, value in values.items() for word in ("-p", f"{name}:={value}")]
        return start("-m", "roadmend.nodes.recorder", "--ros-args", *pairs, **(options or {}))

    return run


@pytest.fixture
def publish(start):
    return lambda *arguments: start(Path(__file__).with_name("publish.py"), *arguments)


def messages_in_cut(path):
    """Topic and bytes of the messages that a file without an end holds so far; none while there is no file."""
    topics = {}
    with contextlib.suppress(EndOfFile, FileNotFoundError), path.open("rb") as stream:
        for one in StreamReader(stream).records:
            if isinstance(one, Channel):
                topics[one.id] = one.topic
            if isinstance(one, Message):
                yield topics[one.channel_id], one.data


def line_of(process):
    """Its next line; what Fast DDS prints among them is passed over."""
    return next((line for line in process.stdout if "[RTPS_" not in re.sub(r"\x1b\[[0-9;]*m", "", line)), "")


def stop(process, number=signal.SIGINT):
    process.send_signal(number)
    _, errors = process.communicate(timeout=60)
    return process.returncode, errors


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_nothing_is_missing_at_full_speed(record, publish, tmp_path, number):
    (tmp_path / "scenario.yaml").write_text("name: merge\n")
    (tmp_path / "metadata.json").write_text(json.dumps({"seed": 7, "method": "rss"}))
    recorder = record(metadata=tmp_path / "metadata.json", attachments=f"[{tmp_path / 'scenario.yaml'}]")
    publisher = publish(COUNT, 0)
    assert line_of(publisher) == "connected\n"
    assert line_of(publisher) == "published\n"
    assert stop(recorder, number)[0] == 0

    bag = BagReader(tmp_path / "bag")
    counts = {topic: bag.topics[topic].count for topic in [*STREAMS, "/route", "/events", "/wall"]}
    assert counts == dict.fromkeys(STREAMS, COUNT) | {"/route": 1, "/events": 2, "/wall": 1}
    assert "/parameter_events" not in bag.topics
    for topic in ("/clock", "/ego", "/objects", "/policy/command"):
        assert [record.time_ns for record in bag.records([topic])] == [tick * TICK_NS for tick in range(COUNT)]
    texts = [message.value.data.split()[0] for message in bag.messages(["/text"])]
    assert sorted(texts, key=int) == [str(tick) for tick in range(COUNT)]
    ticks = [int.from_bytes(bytes(message.value.data[:4]), "little") for message in bag.messages(["/image"])]
    assert sorted(ticks) == list(range(COUNT))
    assert [len(message.value.id) for message in bag.messages(["/objects"])] == [tick % 50 for tick in range(COUNT)]
    (wall,) = bag.records(["/wall"])
    assert wall.time_ns <= COUNT * TICK_NS  # its own stamp is of the wall clock
    account = dict(bag.metadata["roadmend"])
    said = json.loads(account.pop("configuration"))["/recorder_node"]["values"]
    assert (said["node_class"], said["parameters.name"]) == ("roadmend.nodes.recorder.RecorderNode", '"bag"')
    assert account == {
        "seed": "7",
        "method": "rss",
        "messages": f"{bag.count}",
        "lost_messages": "0",
        "outcome": "COLLISION",
        "outcome_text": "hit bus_1",
        "outcome_time": f"{COUNT * TICK_NS / 1e9:g}",
    }
    assert bag.attachments["scenario.yaml"].data == b"name: merge\n"
    assert [offer.durability for offer in bag.topics["/route"].offers] == ["transient_local"]
    with AnyReader([tmp_path / "bag"]) as reader:
        assert sum(1 for _ in reader.messages()) == bag.count


def test_nothing_is_missing_where_the_recorder_was_halted_for_a_second(record, publish, tmp_path):
    """DDS then has to repair losses, every 3 s, and in several rounds: it took less than two before."""
    recorder = record(drain_limit=60.0)
    publisher = publish(COUNT, 0)
    assert line_of(publisher) == "connected\n"
    recorder.send_signal(signal.SIGSTOP)
    time.sleep(1.0)
    recorder.send_signal(signal.SIGCONT)
    assert line_of(publisher) == "published\n"
    assert stop(recorder)[0] == 0
    bag = BagReader(tmp_path / "bag")
    assert {topic: bag.topics[topic].count for topic in STREAMS} == dict.fromkeys(STREAMS, COUNT)
    assert "incomplete" not in bag.metadata["roadmend"]


def test_what_dds_says_of_losses_in_the_end_is_counted(record, publish, tmp_path):
    """Told to stop while it is halted, the recorder hears of them only when it takes in what is left."""
    recorder = record(drain_limit=60.0)
    publisher = publish(COUNT, 0, 100)
    assert line_of(publisher) == "connected\n"
    recorder.send_signal(signal.SIGSTOP)
    assert line_of(publisher) == "published\n"
    recorder.send_signal(signal.SIGTERM)
    assert stop(recorder, signal.SIGCONT)[0] == 0
    bag = BagReader(tmp_path / "bag")
    missing = sum(COUNT - bag.topics[topic].count for topic in STREAMS)
    assert missing > COUNT
    assert bag.metadata["roadmend"]["lost_messages"] == f"{missing}"


def test_diagnostics_tell_how_it_goes(record, publish, tmp_path):
    recorder = record(exclude="^/image$", drain_limit=0.5)
    publisher = publish(10, 0)  # waits for ever, but its topics are there
    deadline = time.monotonic() + 30
    seen = []
    while "/route" not in seen or "/diagnostics" not in seen[seen.index("/route") :]:
        assert time.monotonic() < deadline
        time.sleep(0.2)
        seen = [topic for topic, _ in messages_in_cut(tmp_path / "bag" / "bag_0.mcap")]
    publisher.kill()
    assert stop(recorder)[0] == 0
    bag = BagReader(tmp_path / "bag")
    assert "/image" not in bag.topics
    (status,) = list(bag.messages(["/diagnostics"]))[-1].value.status
    values = {pair.key: pair.value for pair in status.values}
    assert status.name == "recorder_node: bag"
    assert status.level == 0
    assert values["messages lost"] == "0"
    assert int(values["messages"]) > 0
    assert values["bag"] == str(tmp_path / "bag")
    assert bag.metadata["roadmend"]["outcome"] == "UNFINISHED"


def test_sigkill_loses_less_than_a_second(record, publish, tmp_path):
    recorder = record()
    publisher = publish(30_000, 0.002)  # a minute of them
    assert line_of(publisher) == "connected\n"

    def times():
        found = messages_in_cut(tmp_path / "bag" / "bag_0.mcap")
        return [int(data[8:].rstrip(b"\0").split()[1]) for topic, data in found if topic == "/text"]

    # A starved recorder has not received what was sent a second ago: it is killed when it keeps up.
    deadline = time.monotonic() + 60.0
    while len(kept := times()) <= 100 or time.time_ns() - max(kept) >= 1e9:
        assert time.monotonic() < deadline, f"{len(kept)} messages, none of the last second"
        time.sleep(0.1)
    recorder.kill()
    recorder.wait()
    assert times()[: len(kept)] == kept
    assert not (tmp_path / "bag" / "metadata.yaml").exists()


def test_a_later_publisher_that_offers_less_is_recorded_too(record, publish, tmp_path):
    recorder = record(include="^/(text|clock|ego|objects|image|wall|events|route|policy/command)$")
    publisher = publish(10, 0, "late")
    assert [line_of(publisher) for _ in range(3)] == ["connected\n", "published\n", "late\n"]
    assert stop(recorder)[0] == 0
    bag = BagReader(tmp_path / "bag")
    texts = [message.value.data for message in bag.messages(["/text"])]
    assert len(texts) == 11
    assert texts[-1] == "late"


def test_a_recorder_with_nothing_to_record_leaves_an_empty_bag(record, tmp_path):
    recorder = record(include="^/nothing$")
    while not (tmp_path / "bag").exists():
        assert recorder.poll() is None
        time.sleep(0.05)
    time.sleep(0.5)
    assert stop(recorder)[0] == 0
    assert BagReader(tmp_path / "bag").count == 0


@pytest.mark.parametrize(
    ("parameters", "line"),
    [
        ({"include": "'['"}, "roadmend: include: '[' is not a regular expression"),
        ({"exclude": "'('"}, "roadmend: exclude: '(' is not a regular expression"),
        (
            {"compression": "gzip"},
            "roadmend: parameter compression: 'gzip' is not allowed; choose one of zstd, lz4, none",
        ),
        (
            {"time_source": "gps"},
            "roadmend: parameter time_source: 'gps' is not allowed; choose one of simulation, system",
        ),
        ({"metadata": "absent.json"}, "roadmend: absent.json: no such file; write one JSON object"),
        ({"attachments": "[absent.yaml]"}, "roadmend: absent.yaml: no such file; name a file that can be read"),
        ({"output": "/dev/null"}, "roadmend: /dev/null/bag: cannot be written (Not a directory)"),
        ({"chunk_size": "5"}, "chunk_size"),
        ({"flush_interval": "-1.0"}, "flush_interval"),
    ],
)
def test_bad_parameters_end_with_one_line_and_code_2(record, parameters, line):
    recorder = record(**parameters)
    _, errors = recorder.communicate(timeout=30)
    assert recorder.returncode == 2
    (last,) = errors.splitlines()[-1:]
    assert line in last


def test_a_full_disk_is_reported_and_the_graph_goes_on(record, publish, tmp_path):
    limit = 2_000_000  # [bytes] that one file may have
    limited = {"preexec_fn": lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))}
    witness = record(name="witness", include="^/diagnostics$", drain_limit=0.5)
    recorder = record(limited, compression="none", drain_limit=0.5)
    publisher = publish(COUNT, 0)
    assert line_of(publisher) == "connected\n"
    assert line_of(publisher) == "published\n"  # nothing holds it up
    line = f"{tmp_path}/bag/bag_0.mcap: cannot be written (File too large)"
    deadline = time.monotonic() + 30
    while not any(line.encode() in data for _, data in messages_in_cut(tmp_path / "witness" / "witness_0.mcap")):
        assert time.monotonic() < deadline
        assert recorder.poll() is None
        time.sleep(0.2)
    time.sleep(1.2)  # one more report, with what was dropped since
    code, errors = stop(recorder)
    assert code == 1, errors
    assert errors.splitlines()[-1] == f"roadmend: {line}"
    assert stop(witness)[0] == 0
    assert not (tmp_path / "bag" / "metadata.yaml").exists()
    reports = [message.value.status[0] for message in BagReader(tmp_path / "witness").messages(["/diagnostics"])]
    last = next(report for report in reversed(reports) if report.level == 2)  # ERROR
    assert last.message == f"{line}; nothing more is recorded"
    values = {pair.key: int(pair.value) for pair in last.values if pair.key.startswith("messages")}
    assert values["messages dropped"] > 0
    recovery = recover(tmp_path / "bag", tmp_path / "back")
    assert 0 < recovery.count <= values["messages"] + 1  # that at which the writing failed may be there whole


def test_files_of_a_size_and_of_a_duration(record, publish, tmp_path):
    recorder = record(max_bagfile_size=500_000, max_bagfile_duration=10.0, compression="none")
    publisher = publish(COUNT, 0)
    assert [line_of(publisher) for _ in range(2)] == ["connected\n", "published\n"]
    assert stop(recorder)[0] == 0
    files = sorted((tmp_path / "bag").glob("*.mcap"))
    assert len(files) >= 10  # 100 s of messages
    bag = BagReader(tmp_path / "bag")
    assert {topic: bag.topics[topic].count for topic in STREAMS} == dict.fromkeys(STREAMS, COUNT)
    assert bag.topics["/route"].count == 1
    for file in files:
        assert BagReader(file).topics["/route"].count == 1  # it was latched, so each file has it
    with AnyReader([tmp_path / "bag"]) as reader:
        assert sum(1 for _ in reader.messages()) == sum(file.count for file in bag.files)


def test_an_existing_bag_is_not_overwritten(record, tmp_path):
    (tmp_path / "bag").mkdir()
    recorder = record()
    _, errors = recorder.communicate(timeout=30)
    assert recorder.returncode == 2
    assert "bag: exists already; choose another name or remove it" in errors
