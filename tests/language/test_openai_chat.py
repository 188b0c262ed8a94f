"""The openai backend against a real server: what is sent, and what becomes of every kind of answer."""

import base64
import json
import logging

import pytest
import yaml

from roadmend.core.errors import InputError
from roadmend.core.resources import config_folder
from roadmend.language.chat import AnswerError, ChatMessage, ChatRole, Image, RefusalError, Request, UnavailableError
from roadmend.language.exchange import RecordingModel, dump_exchanges
from roadmend.language.openai_chat import OpenAIModel, OpenAISettings, read_openai_settings

from .server import WAIT, completion, serving

KEY = "sk-very-secret-4711"
SCHEMA = {"type": "object", "properties": {}, "required": [], "additionalProperties": False}
REQUEST = Request(
    "answer",
    (
        ChatMessage(ChatRole.SYSTEM, ("Be brief.",)),
        ChatMessage(ChatRole.USER, ("Look:", Image(b"picture", "image/png"))),
    ),
    SCHEMA,
)
ERROR = {"error": {"message": f"wrong key {KEY}", "type": "invalid_request_error", "code": "invalid_api_key"}}


@pytest.fixture
def pauses(monkeypatch):
    """The pauses between attempts, which are not waited for."""
    taken = []
    monkeypatch.setattr("openai._base_client.time.sleep", taken.append)
    return taken


def model(url, **settings):
    return OpenAIModel(OpenAISettings(base_url=url, model="test", api_key=KEY, **settings))


def test_what_is_sent_and_what_comes_back(caplog):
    caplog.set_level(logging.INFO, "roadmend.language")
    with serving(completion("{}")) as (server, url):
        reply = model(url, input_price=2.0, output_price=10.0).ask(REQUEST)
    (sent,) = server.requests
    assert sent["model"] == "test"
    assert sent["messages"][0] == {"role": "system", "content": "Be brief."}
    image = sent["messages"][1]["content"][1]["image_url"]["url"]
    assert image == "data:image/png;base64," + base64.b64encode(b"picture").decode()
    assert sent["response_format"]["json_schema"] == {"name": "answer", "strict": True, "schema": SCHEMA}
    assert server.headers[0]["authorization"] == f"Bearer {KEY}"
    assert server.headers[0]["accept-encoding"] == "identity"  # what is packed may unpack to any size
    assert (reply.text, reply.model, reply.input_tokens, reply.output_tokens) == ("{}", "test-model-1", 1000, 50)
    assert reply.cost == pytest.approx(0.0025)
    assert "1000 tokens in, 50 out, 0.002500 US dollars" in caplog.text


def test_too_many_requests_are_repeated_after_the_pause_that_the_server_asks_for(pauses):
    busy = (429, {"Retry-After": "7"}, {"error": {"message": "slow down"}})
    with serving(busy, busy, completion("{}")) as (server, url):
        assert model(url).ask(REQUEST).text == "{}"
    assert len(server.requests) == 3
    assert pauses == [7.0, 7.0]


def test_server_errors_are_repeated_with_growing_pauses_and_a_bound(pauses):
    with (
        serving((503, {}, {"error": {"message": "down"}})) as (server, url),
        pytest.raises(UnavailableError, match="answered 503"),
    ):
        model(url, attempts=4).ask(REQUEST)
    assert len(server.requests) == 4
    assert len(pauses) == 3
    assert pauses[0] < pauses[2]


def test_a_server_that_does_not_answer_is_given_up(pauses):
    with (
        serving(WAIT) as (server, url),
        pytest.raises(UnavailableError, match=r"did not answer within 0\.05 s, tried 2 times"),
    ):
        model(url, timeout=0.05, attempts=2).ask(REQUEST)
    assert len(server.requests) == 2
    assert len(pauses) == 1


def test_no_server(pauses):
    with serving(completion("{}")) as (_, url):
        pass
    with pytest.raises(UnavailableError, match="cannot be reached"):
        model(url, attempts=2).ask(REQUEST)


def test_a_wrong_key_is_not_repeated_and_not_told():
    with (
        serving((401, {}, ERROR)) as (server, url),
        pytest.raises(UnavailableError, match=r"answered 401: .*\[key\]") as caught,
    ):
        model(url).ask(REQUEST)
    assert len(server.requests) == 1
    assert KEY not in str(caught.value)


@pytest.mark.parametrize(
    ("answer", "error", "complaint"),
    [
        (completion(None, message={"refusal": "I cannot help with that."}), RefusalError, "I cannot help"),
        (completion(None, choice={"finish_reason": "content_filter"}), RefusalError, "content filter"),
        (completion("{", choice={"finish_reason": "length"}), AnswerError, "cut off"),
        (completion(""), AnswerError, "is empty"),
        (completion("{}", choices=[]), AnswerError, "without a choice"),
        ({"nonsense": 1}, AnswerError, "without a choice"),
        (b'{"id": "chatcmpl', AnswerError, "no chat completion"),
    ],
    ids=["refusal", "filter", "cut off", "empty", "no choice", "something else", "broken JSON"],
)
def test_answers_that_are_none(answer, error, complaint):
    with serving(answer) as (server, url), pytest.raises(error, match=complaint):
        model(url).ask(REQUEST)
    assert len(server.requests) == 1


def test_usage_may_be_missing():
    with serving(completion("{}", usage=None)) as (_, url):
        reply = model(url).ask(REQUEST)
    assert (reply.input_tokens, reply.output_tokens, reply.cost) == (0, 0, None)


def test_the_key_is_neither_recorded_nor_logged_nor_shown(caplog):
    caplog.set_level(logging.DEBUG)
    with serving(completion("{}"), (400, {}, ERROR)) as (_, url):
        recorder = RecordingModel(model(url))
        recorder.ask(REQUEST)
        with pytest.raises(UnavailableError):
            recorder.ask(REQUEST)
        assert KEY not in repr(recorder.model.settings)
    record = dump_exchanges(recorder.exchanges)
    assert record.count("\n") == 2
    assert KEY not in record
    assert KEY not in caplog.text


class TestSettings:
    def test_the_file_that_comes_along_holds_the_defaults(self):
        settings = read_openai_settings(config_folder() / "language" / "openai.yaml", {"OPENAI_API_KEY": KEY})
        assert settings == OpenAISettings(api_key=KEY)

    def test_the_environment_wins(self, tmp_path):
        file = tmp_path / "settings.yaml"
        file.write_text(yaml.safe_dump({"model": "one", "timeout": 3, "api_key": "from file"}))
        settings = read_openai_settings(file, {"OPENAI_MODEL": "two", "OPENAI_BASE_URL": "http://localhost:8000/v1"})
        assert (settings.model, settings.timeout, settings.base_url) == ("two", 3, "http://localhost:8000/v1")
        assert settings.api_key.get_secret_value() == "from file"

    def test_no_key(self):
        with pytest.raises(InputError, match="OPENAI_API_KEY: is not set"):
            read_openai_settings(None, {})

    @pytest.mark.parametrize(
        ("text", "complaint"),
        [
            ("[1, 2]", "holds no fields"),
            ("a: [", "broken YAML"),
            ("modell: gpt", "field modell is unknown, did you mean model"),
            ("timeout: 0", "field timeout"),
            ("attempts: 0", "field attempts"),
            ("base_url: ftp://x", "field base_url"),
            ("base_url: http://localhost:80o0/v1", "field base_url.* is no address.*such as http://localhost:8000/v1"),
            ("base_url: http://localhost:99999/v1", "field base_url.* is no address"),
            (f"base_url: 'http://user:{KEY}:8000/v1'", "field base_url.* is no address"),
            ("base_url: http:///v1", "field base_url.* is no address"),
        ],
    )
    def test_broken_files(self, tmp_path, text, complaint):
        file = tmp_path / "settings.yaml"
        file.write_text(text)
        with pytest.raises(InputError, match=complaint) as caught:
            read_openai_settings(file, {"OPENAI_API_KEY": KEY})
        assert KEY not in str(caught.value)

    def test_a_wrong_port_in_the_environment(self):
        with pytest.raises(InputError, match=r"OPENAI_BASE_URL: is no address"):
            read_openai_settings(None, {"OPENAI_API_KEY": KEY, "OPENAI_BASE_URL": "http://localhost:80o0/v1"})

    def test_a_wrong_variable_is_not_the_files_fault(self, tmp_path):
        file = tmp_path / "settings.yaml"
        file.write_text("base_url: http://localhost:8000/v1")
        with pytest.raises(InputError, match=r"OPENAI_BASE_URL: .*https\?://") as caught:
            read_openai_settings(file, {"OPENAI_API_KEY": KEY, "OPENAI_BASE_URL": "localhost:9000"})
        assert str(file) not in str(caught.value)

    def test_spaces_alone_are_nothing(self, tmp_path):
        with pytest.raises(InputError, match="OPENAI_API_KEY: is not set"):
            read_openai_settings(None, {"OPENAI_API_KEY": "   "})
        settings = read_openai_settings(None, {"OPENAI_API_KEY": KEY, "OPENAI_MODEL": " ", "OPENAI_BASE_URL": "\n"})
        assert settings == OpenAISettings(api_key=KEY)
        file = tmp_path / "settings.yaml"
        for text, field in (("model: ' '", "model"), ("api_key: ' '", "api_key")):
            file.write_text(f"api_key: x\n{text}" if field == "model" else text)
            with pytest.raises(InputError, match=f"settings.yaml: field {field}"):
                read_openai_settings(file, {})

    @pytest.mark.parametrize("around", [("", "\n"), ("", "\r\n"), (" ", " \n")])
    def test_a_key_that_was_read_from_a_file_has_a_line_end(self, around):
        begin, end = around
        settings = read_openai_settings(None, {"OPENAI_API_KEY": f"{begin}{KEY}{end}"})
        assert settings.api_key.get_secret_value() == KEY
        assert OpenAISettings(api_key=f"{begin}{KEY}{end}") == OpenAISettings(api_key=KEY)

    @pytest.mark.parametrize("key", [f"{KEY}\u00e9", f"{KEY}\n{KEY}", f"{KEY}\x00"])
    def test_a_key_that_no_header_can_hold_is_refused_and_not_told(self, key):
        with pytest.raises(InputError, match="OPENAI_API_KEY: is no key: ") as caught:
            read_openai_settings(None, {"OPENAI_API_KEY": key})
        assert KEY not in str(caught.value)

    @pytest.mark.parametrize("key", ["sk-very'\"secret-4711", "sk-very\\secret-4711"])
    def test_a_key_is_not_told_in_another_form_of_writing(self, key):
        settings = OpenAISettings(api_key=key)
        for told in (key, repr(key), repr(key.encode()), yaml.safe_dump(key), json.dumps({"key": key})):
            assert "4711" not in settings.without_key(told)

    def test_a_missing_file(self, tmp_path):
        with pytest.raises(InputError, match="no such file"):
            read_openai_settings(tmp_path / "missing.yaml", {"OPENAI_API_KEY": KEY})
