"""Endpoints that do not do what OpenAI's does: each works, or fails in one clear line with the exchange on record."""

import copy
import gzip
import itertools
import json

import pytest

from roadmend.language.chat import AnswerError, ChatMessage, ChatRole, Image, RefusalError, Request, UnavailableError
from roadmend.language.endpoint_habits import PICTURES
from roadmend.language.exchange import RecordingModel, dump_exchanges, load_exchanges
from roadmend.language.openai_chat import OpenAIModel, OpenAISettings

from .server import WAIT, completion, serving

KEY = "sk-very-secret-4711"
SCHEMA = {
    "type": "object",
    "properties": {"colour": {"type": "string"}},
    "required": ["colour"],
    "additionalProperties": False,
}
RED, BLUE = '{"colour": "red"}', '{"colour": "blue"}'
REQUEST = Request(
    "answer",
    (
        ChatMessage(ChatRole.SYSTEM, ("Be brief.",)),
        ChatMessage(ChatRole.USER, ("Which colour?",)),
        ChatMessage(ChatRole.USER, ("Look:", Image(b"picture", "image/png"))),
    ),
    SCHEMA,
)


@pytest.fixture(autouse=True)
def pauses(monkeypatch):
    """The pauses between attempts, which are not waited for."""
    taken = []
    monkeypatch.setattr("openai._base_client.time.sleep", taken.append)
    return taken


def ask(*answers, key=KEY, request=REQUEST, times=1, **settings):
    """Ask an endpoint; gives the last reply, what was sent to it, and what was recorded, as it is kept in a file."""
    with serving(*answers) as (server, url):
        given = {"base_url": url, "model": "test", "api_key": key, "attempts": 2, "timeout": 5.0} | settings
        recorder = RecordingModel(OpenAIModel(OpenAISettings(**given)))
        try:
            for _ in range(times):
                reply = recorder.ask(request)
        except Exception as error:
            error.requests = server.requests
            error.record = dump_exchanges(recorder.exchanges)
            raise
    return reply, server.requests, dump_exchanges(recorder.exchanges)


def turned_down(message, status=400):
    return status, {}, {"error": {"message": message, "type": "invalid_request_error", "param": None}}


def shown(body):
    return json.dumps(body["messages"])


class Picky:
    """Turns down what it does not take, one thing at a time, as servers do."""

    def __init__(self, **complaints):
        self.complaints = complaints

    def __call__(self, body):
        form = body.get("response_format", {}).get("type")
        roles = [message["role"] for message in body["messages"]]
        has = {
            "json_schema": form == "json_schema",
            "json_object": form == "json_object",
            "images": "image_url" in shown(body),
            "temperature": "temperature" in body,
            "max_tokens": "max_tokens" in body,
            "max_completion_tokens": "max_completion_tokens" in body,
            "system": "system" in roles,
            "neighbours": any(one == other for one, other in itertools.pairwise(roles)),
        }
        for name, complaint in self.complaints.items():
            if has[name]:
                return complaint if isinstance(complaint, tuple) else turned_down(complaint)
        return completion(RED)


class TestWhatIsNotTaken:
    """An endpoint's complaint names what it does not take; it is asked again without, and that is remembered."""

    def test_no_json_schema(self):
        picky = Picky(json_schema="'response_format' of type 'json_schema' is not supported with this model.")
        reply, sent, record = ask(picky, times=2)
        assert reply.text == RED
        forms = [body["response_format"]["type"] for body in sent]
        assert forms == ["json_schema", "json_object", "json_object"]  # the second time it is known
        assert '\\"required\\": [\\"colour\\"]' in shown(sent[1])  # the schema in words, then
        assert "the schema as a parameter" in record

    def test_no_form_at_all(self):
        picky = Picky(
            json_schema="This response_format type is unavailable now",
            json_object=turned_down("response_format: extra fields not permitted", 422),
        )
        reply, sent, _ = ask(picky)
        assert reply.text == RED
        assert ["response_format" in body for body in sent] == [True, True, False]
        assert "Answer with one JSON object" in shown(sent[-1])

    @pytest.mark.parametrize(
        "complaint",
        [
            "messages[2]: unknown variant `image_url`, expected `text` at line 1 column 20",
            turned_down("image input is not supported - hint: you may need to provide the mmproj", 500),
            turned_down("This model does not support vision.", 404),
            turned_down("invalid type: sequence, expected a string", 422),
            (413, {"Content-Type": "text/html"}, b"<html><title>413 Request Entity Too Large</title></html>"),
        ],
        ids=["unknown variant", "llama.cpp", "no vision", "texts alone", "too large"],
    )
    def test_no_images(self, complaint):
        reply, sent, record = ask(Picky(images=complaint))
        assert reply.text == RED
        assert PICTURES in reply.left_out
        assert "image_url" in shown(sent[0])
        assert "image_url" not in shown(sent[-1])
        assert "A picture belongs here" in shown(sent[-1])
        assert all(isinstance(message["content"], str) for message in sent[-1]["messages"])
        assert PICTURES in record

    def test_a_picture_that_is_not_taken_says_nothing_of_the_next_one(self):
        reply, sent, _ = ask(turned_down("Invalid image: image/bmp"), completion(RED), completion(RED), times=2)
        assert ["image_url" in shown(body) for body in sent] == [True, False, True]
        assert reply.left_out == ()

    def test_a_request_without_pictures_lacks_none(self):
        words = Request("answer", REQUEST.messages[:2], SCHEMA)
        reply, _, _ = ask(Picky(images="no images"), request=words)
        assert reply.left_out == ()

    def test_no_temperature(self):
        complaint = "Unsupported value: 'temperature' does not support 0 with this model. Only 1 is supported."
        reply, sent, _ = ask(Picky(temperature=complaint))
        assert ["temperature" in body for body in sent] == [True, False]
        assert reply.left_out == ("temperature 0",)

    def test_a_bound_by_another_name(self):
        _, sent, _ = ask(completion(RED))
        assert not {"max_tokens", "max_completion_tokens"} & sent[0].keys()  # none unless it is asked for
        _, sent, _ = ask(completion(RED), max_tokens=900)
        assert sent[0]["max_completion_tokens"] == 900
        older = Picky(max_completion_tokens=turned_down("max_completion_tokens: Extra inputs are not permitted", 422))
        _, sent, _ = ask(older, max_tokens=900)
        assert "max_completion_tokens" not in sent[1]
        assert sent[1]["max_tokens"] == 900
        neither = Picky(max_completion_tokens="max_completion_tokens?", max_tokens="Unrecognized argument: max_tokens")
        _, sent, _ = ask(neither, max_tokens=900)
        assert not {"max_tokens", "max_completion_tokens"} & sent[2].keys()

    @pytest.mark.parametrize(
        "complaint",
        [
            {"system": "System role not supported"},
            {"neighbours": turned_down("Conversation roles must alternate user/assistant/user/assistant", 500)},
        ],
    )
    def test_strict_roles(self, complaint):
        _, sent, _ = ask(Picky(**complaint))
        (message,) = sent[-1]["messages"]  # all that was said before an answer, in its order
        assert message["role"] == "user"
        assert json.dumps(message).index("Be brief") < json.dumps(message).index("Look:")

    def test_all_of_it(self):
        picky = Picky(
            temperature="temperature is not supported",
            images="no image input here",
            system="System role not supported",
            json_schema="json_schema is not supported",
            json_object="response_format is not supported",
        )
        reply, sent, _ = ask(picky, times=2)
        assert reply.text == RED
        assert len(sent) == 7  # five lessons, and two answers
        assert {*reply.left_out} == {PICTURES, "the schema as a parameter", "temperature 0"}

    def test_what_names_nothing_ends_the_matter(self):
        with pytest.raises(UnavailableError, match=r"answered 400: .*context length") as caught:
            ask(turned_down("This model's maximum context length is 8192 tokens"))
        assert len(caught.value.requests) == 1

    def test_an_endpoint_that_takes_nothing_ends_it_too(self):
        with pytest.raises(UnavailableError, match="answered 400") as caught:
            ask(turned_down("response_format, image, temperature and system role are not supported"))
        assert len(caught.value.requests) == 6


@pytest.mark.parametrize(
    "content",
    [
        RED,
        f"```json\n{RED}\n```",
        f"Here you are:\n\n```\n{RED}\n```\nAsk if you need more.",
        f"The answer is {RED}, as the report says.",
        f"<think>Perhaps {BLUE}? No, {{red}}.</think>\n{RED}",
        f"<think>Perhaps\n```json\n{BLUE}\n```</think>```json\n{RED}\n```",
        f"Perhaps {BLUE}? No.\n</think>\n\n{RED}",
        f'The schema was {{"type": "object"}}. {RED}',
        f"{RED}\n\n{RED}",
        "\ufeff" + RED,
        [{"type": "text", "text": RED}],
    ],
    ids=[
        "plain",
        "fenced",
        "fence and prose",
        "prose",
        "thoughts",
        "thoughts with a fence",
        "thoughts without a begin",
        "another object",
        "twice the same",
        "byte order mark",
        "in parts",
    ],
)
def test_where_an_answer_may_stand(content):
    reply, sent, _ = ask(completion(content))
    assert json.loads(reply.text) == {"colour": "red"}
    assert len(sent) == 1


def test_two_answers_are_none():
    with pytest.raises(AnswerError, match="2 different JSON objects"):
        ask(completion(f"Either {RED} or {BLUE}."))


def test_text_without_an_answer_is_handed_on_to_be_refused():
    assert ask(completion("I do not know {that}."))[0].text == "I do not know {that}."
    assert ask(completion("{" * 100_000))[0].text.startswith("{{")


@pytest.mark.timeout(30)
@pytest.mark.parametrize("text", ["<title>", "<title"])
def test_a_page_of_marks_without_an_end_is_looked_at_once(text):
    with pytest.raises(AnswerError, match="a page for people"):
        ask(text.encode() * 200_000)  # from each of them to the end it would outlast the tests


HTML = b"<!DOCTYPE html><html><head><title>502\n Bad Gateway</title></head><body>nginx</body></html>"
EVENTS = b'data: {"choices": [{"delta": {"content": "{\\"col'
SHORT = (200, {"Content-Length": "5000"}, json.dumps(completion(RED)).encode())


@pytest.mark.parametrize(
    ("answer", "error", "line"),
    [
        (completion(None, message={"refusal": "I cannot\nhelp."}), RefusalError, "the model declined: I cannot help."),
        (completion(None, choice={"finish_reason": "content_filter"}), RefusalError, "content filter .* withheld"),
        (turned_down("content_filter: the prompt was filtered"), RefusalError, "content filter turned the request"),
        ({"error": {"message": "No instances available", "code": 502}}, UnavailableError, "No instances available"),
        ({"error": {"code": "content_filter", "message": "no"}}, RefusalError, "content filter"),
        (completion(RED[:9], choice={"finish_reason": "length"}), AnswerError, "cut off"),
        (completion(RED, choices=[]), AnswerError, "without a choice"),
        (completion(RED, choices=None), AnswerError, "without a choice"),
        (completion(RED, choices=["red"]), AnswerError, "without a choice"),
        (completion(RED, choices={"0": RED}), AnswerError, "without a choice"),
        (completion(RED, choice={"message": RED}), AnswerError, "without a choice"),
        (completion(None), AnswerError, "is empty"),
        (completion(7), AnswerError, "is empty"),
        (completion([{"type": "image"}, 3]), AnswerError, "is empty"),
        (b"", AnswerError, "the body is empty"),
        (b"[]", AnswerError, "no JSON object"),
        (b'{"id": "chatcmpl', AnswerError, "broken JSON"),
        (b"[" * 500, AnswerError, "broken JSON"),
        ((200, {"Content-Type": "text/html"}, HTML), AnswerError, "a page for people: 502 Bad Gateway"),
        ((502, {"Content-Type": "text/html"}, HTML), UnavailableError, "answered 502: 502 Bad Gateway"),
        ((200, {"Content-Type": "text/event-stream"}, EVENTS), AnswerError, "a stream of events"),
        (json.dumps(completion("\u00fc"), ensure_ascii=False).encode("latin-1"), AnswerError, "no UTF-8"),
        ((200, {"Content-Encoding": "gzip"}, gzip.compress(RED.encode())), AnswerError, "a compressed body"),
        (completion("x" * 9_000_000), AnswerError, "more than 8 MB"),
        ((400, {}, b"x" * 9_000_000), AnswerError, "more than 8 MB"),
        ((503, {}, {"error": {"message": "overloaded"}}), UnavailableError, "answered 503: .*overloaded"),
        ((429, {"Retry-After": "9"}, {"error": {"message": "slow down"}}), UnavailableError, "answered 429"),
        (SHORT, UnavailableError, "cannot be reached"),
        (WAIT, UnavailableError, "did not answer within"),
        ([b" "] * 100, UnavailableError, "did not answer within"),
    ],
    ids=[
        "refusal",
        "answer filtered",
        "request filtered",
        "error with status 200",
        "filtered with status 200",
        "truncated",
        "no choices",
        "choices null",
        "a word for a choice",
        "choices in an object",
        "a word for a message",
        "no content",
        "a number",
        "parts without text",
        "nothing",
        "a list",
        "half a body",
        "deeply nested",
        "HTML",
        "HTML with status 502",
        "events",
        "Latin-1",
        "compressed",
        "huge",
        "huge error",
        "overloaded",
        "rate limit",
        "connection lost",
        "silent",
        "trickling",
    ],
)
def test_what_is_no_answer_fails_in_one_line_and_is_recorded(answer, error, line, tmp_path):
    slow = {"timeout": 0.2} if answer == WAIT or isinstance(answer, list) else {}
    with pytest.raises(error, match=line) as caught:
        ask(answer, **slow)
    assert type(caught.value) is error
    told = str(caught.value)
    assert "\n" not in told
    assert len(told) < 400
    (tmp_path / "case.exchanges.jsonl").write_text(caught.value.record)
    (exchange,) = load_exchanges(tmp_path / "case.exchanges.jsonl")
    assert (exchange.reply, exchange.error) == (None, told)
    assert KEY not in caught.value.record


def test_trouble_that_passes_is_not_told(pauses):
    troubles = [
        (429, {"Retry-After": "7"}, {"error": {"message": "slow down"}}),
        (500, {}, b"oops"),
        SHORT,
        (529, {}, {"error": {"message": "overloaded"}}),
        completion(RED),
    ]
    reply, sent, _ = ask(*troubles, attempts=5)
    assert reply.text == RED
    assert len(sent) == 5
    assert pauses[0] == 7.0
    assert reply.left_out == ()


@pytest.mark.parametrize("kind", ["text/plain; charset=utf-8", "application/octet-stream", "text/html"])
def test_a_wrong_content_type_does_not_matter(kind):
    assert ask((200, {"Content-Type": kind}, json.dumps(completion(RED)).encode()))[0].text == RED


def test_what_is_missing_beside_the_answer_does_not_matter():
    reply, _, _ = ask({"choices": [{"message": {"content": RED}}]})
    assert (reply.text, reply.model, reply.input_tokens, reply.output_tokens) == (RED, "test", 0, 0)
    odd = completion(RED, usage={"prompt_tokens": "many"}, model=None)
    assert ask(odd)[0].input_tokens == 0


class TestTheKey:
    """Endpoints that repeat it, in every place that is told or kept."""

    def test_in_an_answer(self):
        reply, _, record = ask(completion(f'{{"colour": "{KEY}"}}', model=KEY))
        assert KEY not in repr(reply)
        assert KEY not in record
        assert json.loads(reply.text) == {"colour": "[key]"}

    @pytest.mark.parametrize(
        "answer",
        [
            (401, {}, {"error": {"message": f"wrong key {KEY}"}}),
            (401, {"Content-Type": "text/html"}, f"<title>{KEY}</title>".encode()),
            {"error": {"message": f"wrong key {KEY}"}},
            completion(None, message={"refusal": f"not with {KEY}"}),
            f"<p>{KEY}</p>".encode(),
        ],
    )
    def test_in_what_is_none(self, answer, caplog):
        caplog.set_level("DEBUG", "roadmend")
        with pytest.raises((UnavailableError, RefusalError, AnswerError)) as caught:
            ask(copy.deepcopy(answer))
        assert KEY not in str(caught.value) + caught.value.record + caplog.text
        assert "[key]" in str(caught.value)

    def test_in_the_address(self):
        settings = OpenAISettings(base_url=f"https://user:{KEY}@host/v1?token={KEY}", api_key="none")
        assert settings.place == "https://host/v1"
        assert KEY not in OpenAIModel(settings).identity

    def test_a_word_for_a_server_that_wants_none_spoils_no_answer(self):
        assert ask(completion(RED), key="red")[0].text == RED
