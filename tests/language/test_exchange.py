"""Recorded exchanges: written, read back, replayed, and nothing beyond."""

import contextlib

import pytest

from roadmend.core.errors import InputError
from roadmend.language.chat import (
    ChatMessage,
    ChatRole,
    Image,
    LanguageError,
    NotRecordedError,
    RefusalError,
    Reply,
    Request,
)
from roadmend.language.exchange import RecordingModel, ReplayModel, dump_exchanges, load_exchanges


def request(text, image=b"1"):
    return Request("answer", (ChatMessage(ChatRole.USER, (text, Image(image, "image/png"))),), {"type": "object"})


class Counting:
    def __init__(self):
        self.count = 0

    def ask(self, request):
        self.count += 1
        if request == BAD:
            raise RefusalError("no")
        return Reply(f"answer {self.count}", "counting", 3, 2, 0.1)


GOOD, BAD = request("good"), request("bad")


@pytest.fixture
def recording(tmp_path):
    recorder = RecordingModel(Counting())
    for each in (GOOD, GOOD, BAD):
        with contextlib.suppress(LanguageError):
            recorder.ask(each)
    path = tmp_path / "case.exchanges.jsonl"
    path.write_text(dump_exchanges(recorder.exchanges))
    assert load_exchanges(path) == tuple(recorder.exchanges)
    return path


def test_a_request_gets_its_answers_in_order_and_no_more(recording):
    replay = ReplayModel(recording.parent)
    assert replay.ask(GOOD) == Reply("answer 1", "counting", 3, 2, 0.1)
    assert replay.ask(GOOD).text == "answer 2"
    with pytest.raises(NotRecordedError, match=r"no .*answer to this request for answer"):
        replay.ask(GOOD)


def test_what_failed_fails_again(recording):
    with pytest.raises(LanguageError, match="no"):
        ReplayModel(recording).ask(BAD)


@pytest.mark.parametrize("other", [request("other"), request("good", b"2"), Request("answer", GOOD.messages, {})])
def test_a_request_that_was_not_recorded(recording, other):
    with pytest.raises(NotRecordedError):
        ReplayModel(recording).ask(other)


def test_recordings_that_are_none(tmp_path):
    with pytest.raises(InputError, match="holds no recording"):
        ReplayModel(tmp_path)
    with pytest.raises(InputError, match="no such file"):
        ReplayModel(tmp_path / "missing.jsonl")
    (tmp_path / "x.exchanges.jsonl").write_text('{"digest": 1}\n')
    with pytest.raises(InputError, match="line 1: is no exchange"):
        ReplayModel(tmp_path)
