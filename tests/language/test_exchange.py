"""Recorded exchanges: written, read back, replayed, and nothing beyond."""

import contextlib
import json

import pytest

from roadmend.core.errors import InputError
from roadmend.language.chat import (
    AnswerError,
    ChatMessage,
    ChatRole,
    Image,
    LanguageError,
    NotRecordedError,
    RefusalError,
    Reply,
    Request,
    UnavailableError,
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


class Failing:
    def __init__(self, error):
        self.error = error

    def ask(self, request):
        raise self.error


class OwnError(AnswerError):
    """Of a model of somebody's own."""


@pytest.mark.parametrize(
    ("kind", "again"),
    [
        (AnswerError, AnswerError),
        (RefusalError, RefusalError),
        (UnavailableError, UnavailableError),
        (NotRecordedError, NotRecordedError),
        (LanguageError, LanguageError),
        (OwnError, AnswerError),
    ],
)
def test_of_the_kind_that_it_failed_with(kind, again, tmp_path):
    recorder = RecordingModel(Failing(kind("cut off")))
    with pytest.raises(kind):
        recorder.ask(GOOD)
    path = tmp_path / "case.exchanges.jsonl"
    path.write_text(dump_exchanges(recorder.exchanges))
    with pytest.raises(LanguageError, match="cut off") as caught:
        ReplayModel(path).ask(GOOD)
    assert type(caught.value) is again


@pytest.mark.parametrize("kind", [{}, {"kind": "Unheard"}])
def test_a_recording_without_the_kind_or_with_a_later_one_is_read(kind, tmp_path):
    path = tmp_path / "case.exchanges.jsonl"
    old = {"digest": GOOD.digest(), "request": {}, "reply": None, "error": "cut off"}
    path.write_text(json.dumps(old | kind) + "\n")
    with pytest.raises(LanguageError, match="cut off") as caught:
        ReplayModel(path).ask(GOOD)
    assert type(caught.value) is LanguageError


def test_what_ends_a_line_to_unicode_does_not_in_a_recording(tmp_path):
    class Odd:
        def ask(self, request):
            return Reply("a\u2028b\u2029c\u0085d\x0be\x1cf\r\ng", "odd")

    recorder = RecordingModel(Odd())
    recorder.ask(GOOD)
    path = tmp_path / "case.exchanges.jsonl"
    path.write_text(dump_exchanges(recorder.exchanges), encoding="utf-8")
    assert load_exchanges(path) == tuple(recorder.exchanges)
    path.write_text("")
    assert load_exchanges(path) == ()


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
    broken = {"digest": "1", "request": {}, "reply": None, "error": "no", "kind": ["AnswerError"]}
    (tmp_path / "x.exchanges.jsonl").write_text(json.dumps(broken) + "\n")
    with pytest.raises(InputError, match="line 1: is no exchange"):
        ReplayModel(tmp_path)


@pytest.mark.parametrize(
    "damage",
    [
        {"digest": [1]},
        {"digest": 1},
        {"request": "good"},
        {"error": 5},
        {"reply": []},
        {"reply": {"text": 5}},
        {"reply": {"text": None}},
        {"reply": {"input_tokens": "abc"}},
        {"reply": {"cost": "x"}},
        {"reply": {"left_out": "abc"}},
        {"reply": {"more": 1}},
    ],
    ids=str,
)
def test_a_recording_that_is_damaged_is_refused(recording, damage):
    first, rest = recording.read_text().split("\n", 1)
    content = json.loads(first)
    reply = damage.get("reply")
    damage = damage | ({"reply": content["reply"] | reply} if reply else {})
    recording.write_text(json.dumps(content) + "\n" + json.dumps(content | damage) + "\n" + rest)
    with pytest.raises(InputError, match="line 2: is no exchange"):
        ReplayModel(recording)
