"""A language model of one's own."""

import pytest

from roadmend.core.errors import ForeignError
from roadmend.language.chat import AnswerError, RefusalError, Request
from roadmend.language.models import open_model
from roadmend.safe.backends import BackendOptions, open_extractor
from roadmend.safe.stage_one import StageOneOptions
from roadmend.sera.backends import Backend

MODEL = """
from roadmend.language.chat import RefusalError, Reply

class Echo:
    identity = "echo 1"
    def __init__(self, settings=None):
        self.settings = settings
    def ask(self, request):
        if request.purpose == "refused":
            raise RefusalError("no")
        if request.purpose == "broken":
            raise KeyError("lost")
        if request.purpose == "empty":
            return "text"
        return Reply("{}", "echo")
"""


def ask(model, purpose):
    return model.ask(Request(purpose, (), {}))


def test_it_answers_and_its_code_tells_it_from_another(own):
    given = f"{own(MODEL)}:Echo"
    model = open_model(given, "there.yaml")
    assert ask(model, "anything").text == "{}"
    assert model.model.settings == "there.yaml"
    other = open_model(f"{own(MODEL.replace('{}', '[]'))}:Echo")
    assert given in model.identity
    assert "echo 1" in model.identity
    assert model.identity.split()[1] != other.identity.split()[1]


def test_what_it_fails_in_is_said_in_one_line(own):
    given = f"{own(MODEL)}:Echo"
    model = open_model(given)
    with pytest.raises(RefusalError):
        ask(model, "refused")
    with pytest.raises(ForeignError, match=f"backend {given}: failed in ask for broken: KeyError: 'lost'"):
        ask(model, "broken")
    with pytest.raises(AnswerError, match="answered with str, not a roadmend"):
        ask(model, "empty")


def test_reading_and_analysing_take_it(own):
    given = f"{own(MODEL)}:Echo"
    assert given in open_extractor(given, BackendOptions(StageOneOptions())).model.identity
    assert given in Backend.open(given).model.model.identity
    assert Backend.open("embedded").model is None
