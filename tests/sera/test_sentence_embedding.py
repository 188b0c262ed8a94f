"""Banks made with other embedders than the built-in one: they remember which, and nothing is mixed."""

import sys
from pathlib import Path

import numpy as np
import pytest

from roadmend.core.errors import InputError
from roadmend.language.chat import AnswerError, UnavailableError
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.pattern import FailurePattern
from roadmend.sera.words import words_of

from ..language.server import embeddings, serving  # noqa: TID252 - one server for all rooms
from .banks import cut_in, entry
from .encoders import letters, other, short

ENTRIES = [entry("plain"), entry("rain", weather="rainy"), entry("cut", hazards=cut_in("truck"))]
KEY = "sk-very-secret"
LETTERS = "python:encoders:letters"


@pytest.fixture(autouse=True)
def _encoders(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parent))
    yield
    sys.modules.pop("encoders", None)


@pytest.fixture
def endpoint(monkeypatch):
    def use(url, model="small"):
        monkeypatch.setenv("OPENAI_BASE_URL", url)
        monkeypatch.setenv("OPENAI_API_KEY", KEY)
        monkeypatch.setenv("OPENAI_EMBEDDING_MODEL", model)

    return use


def found(path, embedder=None):
    with Bank(path, embedder) as bank:
        wanted = words_of(ENTRIES[2].descriptor)
        return [bank.entry(hit.number).name for hit in bank.search(FailurePattern("x", wanted), 1)]


def test_an_endpoint_embeds_and_the_bank_remembers_its_model(tmp_path, endpoint):
    path = tmp_path / "b"
    with serving(embeddings(lambda text: letters([text])[0])) as (server, url):
        endpoint(url)
        build_bank(path, ENTRIES, "openai")
        endpoint(url, "another")  # the bank's model is asked, not the one that is set now
        assert found(path) == found(path, "openai") == found(path, "openai:small") == ["cut"]
    assert {body["model"] for body in server.requests} == {"small"}
    assert KEY.encode() not in path.read_bytes()
    assert url.encode() not in path.read_bytes()
    with Bank(path) as bank:
        assert bank.meta["embedder"] == "openai:small"
        np.testing.assert_allclose(np.linalg.norm(bank.vectors([0, 1, 2]), axis=1), 1.0, atol=1e-3)


@pytest.mark.parametrize("encode", [other, short])
def test_an_endpoint_that_has_changed_its_model_is_refused(tmp_path, endpoint, encode):
    path = tmp_path / "b"
    with serving(embeddings(lambda text: letters([text])[0])) as (_, url):
        endpoint(url)
        build_bank(path, ENTRIES, "openai:small")
    with serving(embeddings(lambda text: encode([text])[0])) as (_, url):
        endpoint(url)
        with pytest.raises(InputError, match="openai:small: gives other vectors than those in the bank"):
            found(path)


@pytest.mark.parametrize(
    ("answer", "error", "complaint"),
    [
        ((401, {}, {"error": {"message": f"bad key {KEY}"}}), UnavailableError, r"401.*\[key\]"),
        ({"object": "list", "model": "m", "data": []}, AnswerError, "one vector for each of 1 texts"),
        *(
            ({"object": "list", "model": "m", "data": data}, AnswerError, "one vector for each of 1 texts")
            for data in (["x"], [{"object": "embedding", "index": 0, "embedding": None}], [{"index": 0}])
        ),
        (
            {"object": "list", "model": "m", "data": [{"object": "embedding", "index": 0, "embedding": ["x"]}]},
            AnswerError,
            "one vector for each of 1 texts",
        ),
        (b"not JSON", AnswerError, "127.0.0.1"),
    ],
)
def test_an_endpoint_in_trouble_is_an_error_and_no_bank(tmp_path, endpoint, answer, error, complaint):
    with serving(answer) as (_, url):
        endpoint(url)
        with pytest.raises(error, match=complaint) as caught:
            build_bank(tmp_path / "b", ENTRIES, "openai")
    assert KEY not in str(caught.value)
    assert not list(tmp_path.iterdir())


def test_code_of_the_user_embeds_when_the_user_names_it_and_not_otherwise(tmp_path):
    path = tmp_path / "b"
    build_bank(path, ENTRIES, LETTERS)
    assert found(path, LETTERS) == ["cut"]
    sys.modules.pop("encoders")
    for named in (None, "python"):
        with pytest.raises(InputError, match=f"not run on a bank's word; give --embedder {LETTERS} if you trust it"):
            found(path, named)
    assert "encoders" not in sys.modules
    with Bank(path) as bank:
        assert [each.name for each in bank.entries()] == ["plain", "rain", "cut"]  # reading runs nothing


def test_another_embedder_than_the_banks_is_refused(tmp_path):
    build_bank(tmp_path / "b", ENTRIES)
    for named in (LETTERS, "openai"):
        with pytest.raises(InputError, match=f"made with 'latent', and vectors of '{named}' do not mix"):
            Bank(tmp_path / "b", named)
    assert found(tmp_path / "b", "latent") == ["cut"]


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("oracle", "there is no 'oracle'"),
        ("latent:big", "there is no 'latent:big'"),
        ("python:nowhere:encode", "cannot be imported .ModuleNotFoundError"),
        ("python:encoders:nothing_there", "cannot be imported .AttributeError"),
        ("python:encoders", "cannot be imported"),
        ("python:encoders:NUMBER", "cannot be called"),
        ("python:encoders:failing", "failed .KeyError"),
        ("python:encoders:flat", r"gives the shape \(1,\) for 1 texts"),
        ("python:encoders:endless", "zero or not finite"),
        ("python:encoders:nothing", "zero or not finite"),
    ],
)
def test_what_is_no_embedder_is_refused(tmp_path, name, complaint):
    with pytest.raises(InputError, match=complaint):
        build_bank(tmp_path / "b", ENTRIES, name)
    assert not list(tmp_path.iterdir())


def test_a_pattern_without_words_says_nothing(tmp_path):
    build_bank(tmp_path / "b", ENTRIES, LETTERS)
    with Bank(tmp_path / "b", LETTERS) as bank, pytest.raises(InputError, match="says nothing that this bank knows"):
        bank.search(FailurePattern("x"), 1)
