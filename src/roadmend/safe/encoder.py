"""The information encoder: a model's answers as elements of the scenario language, or what is wrong with them."""

from dataclasses import dataclass
from typing import Any

from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.language.chat import AnswerError
from roadmend.safe.dsl import CrashScenario, Position, RoadType
from roadmend.safe.dsl_data import parse_data


@dataclass(frozen=True, slots=True)
class MetaMessage:
    """What the knowledge base is searched with."""

    road_type: RoadType
    directions: tuple[Position | None, ...]


def encode_meta(text: str) -> MetaMessage:
    """Turn an answer into a meta message.

    Raises:
        AnswerError: a field is missing, unknown, or has a value that the language does not have.
    """
    fields = _object(text, {"analysis", "road_type", "number_of_vehicles", "driving_directions"})
    directions, count = fields["driving_directions"], fields["number_of_vehicles"]
    if not isinstance(directions, list) or count != len(directions):
        raise AnswerError(f"driving_directions has not one entry for each of the {count} vehicles")
    if not directions:
        raise AnswerError("number_of_vehicles is 0; a crash has at least one")
    try:
        return MetaMessage(
            RoadType(fields["road_type"]), tuple(None if each is None else Position(each) for each in directions)
        )
    except ValueError as error:
        raise AnswerError(str(error)) from None


def encode_scenario(text: str) -> CrashScenario:
    """Turn an answer into a scenario: the information encoder.

    Raises:
        AnswerError: a field is missing, unknown, not asked for, or has a value that the language does not have.
    """
    fields = _object(text, {"analysis", "scenario"})
    try:
        scenario = parse_data(fields["scenario"], "the answer")
    except InputError as error:
        raise AnswerError(f"{error.where}: {error.what}") from None
    # Fields of a user's own may hold anything; the schema asks for none, and nothing speaks for or against one.
    extras = (scenario.extras, scenario.environment.extras, *(vehicle.extras for vehicle in scenario.vehicles))
    own = [name for each in extras for name in each]
    if own:
        raise AnswerError(f"the answer: field {own[0][:60]} was not asked for")
    return scenario


def encode_verdict(text: str) -> tuple[str, list[str]]:
    """Turn an answer into the validator's verdict and objections.

    Raises:
        AnswerError: it is none.
    """
    fields = _object(text, {"verdict", "problems"})
    verdict, problems = fields["verdict"], fields["problems"]
    if not isinstance(verdict, str) or verdict not in {"Pass", "Fail"} or not isinstance(problems, list):
        raise AnswerError(f"verdict {verdict!r} is neither Pass nor Fail")
    return verdict, [str(problem) for problem in problems]


def _object(text: str, names: set[str]) -> dict[str, Any]:
    try:
        content = parse_json(text, "answer")
    except InputError:
        raise AnswerError("the answer is broken JSON") from None
    if not isinstance(content, dict):
        raise AnswerError("the answer is no JSON object")
    if content.keys() != names:
        wrong = ", ".join(sorted(content.keys() ^ names))
        raise AnswerError(f"fields are missing or unknown: {wrong}")
    return content
