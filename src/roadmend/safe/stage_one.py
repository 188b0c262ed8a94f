"""Stage I of SAFE with a language model: algorithm 1 of the paper."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.language.chat import AnswerError, ChatModel, LanguageError, Request
from roadmend.language.exchange import RecordingModel
from roadmend.language.question import ATTEMPTS, ask_until_accepted
from roadmend.safe.dsl import CrashScenario, Position, RoadType
from roadmend.safe.dsl_data import dump_data, parse_data
from roadmend.safe.extraction import Extraction, ExtractionError, FieldEvidence, Step, Watch, unwatched
from roadmend.safe.knowledge_base import retrieve
from roadmend.safe.prompts import extraction_request, meta_request, validation_request
from roadmend.safe.report import CrashReport

Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class StageOneOptions:
    """What can be switched off to see what it is good for.

    Attributes:
        prompt_generation: ask with the template and the example that the knowledge base has for such a road.
        validation: let the model check each answer against the report.
        attempts: how often a step is executed before the report is given up.
    """

    prompt_generation: bool = True
    validation: bool = True
    attempts: int = ATTEMPTS


@dataclass(frozen=True, slots=True)
class MetaMessage:
    """What the knowledge base is searched with."""

    road_type: RoadType
    directions: tuple[Position | None, ...]


class LanguageExtractor:
    """Extracts with a language model.

    Args:
        model: that answers.
        options: see ``StageOneOptions``.
    """

    def __init__(self, model: ChatModel, options: StageOneOptions) -> None:
        self.model = model
        self.options = options

    def extract(self, report: CrashReport, watch: Watch = unwatched) -> Extraction:
        """Extract one report.

        Raises:
            ExtractionError: the model gave no answer, or none that passed, as often as it was asked.
        """
        model = RecordingModel(self.model)
        steps = _CheckedSteps(model, report, self.options, watch)
        try:
            if self.options.prompt_generation:
                _, example = retrieve(RoadType.T_INTERSECTION, ())
                meta = steps.run("the meta message", lambda o: meta_request(report, example, o), encode_meta)
                found = retrieve(meta.road_type, meta.directions)
            else:
                found = None
            scenario = steps.run("the scenario", lambda o: extraction_request(report, found, o), encode_scenario)
        except LanguageError as error:
            raise ExtractionError(str(error), tuple(model.exchanges)) from None
        sketch = "read: sent to the model beside the summary" if report.sketch is not None else "there is none"
        notes = [*report.notes]
        if not self.options.prompt_generation:
            notes.append("asked without the knowledge base")
        if not self.options.validation:
            notes.append("answers were not validated")
        return Extraction(scenario, _evidence(scenario), sketch, tuple(notes), tuple(model.exchanges))


class _CheckedSteps:
    """Executes a step until its answer can be encoded and passes, within a bound."""

    def __init__(self, model: ChatModel, report: CrashReport, options: StageOneOptions, watch: Watch) -> None:
        self.model = model
        self.report = report
        self.options = options
        self.watch = watch

    def run(self, what: str, ask: Callable[[Sequence[str]], Request], encode: Callable[[str], Answer]) -> Answer:
        attempt, attempts = 0, self.options.attempts

        def next_request(objections: Sequence[str]) -> Request:
            nonlocal attempt
            attempt += 1
            request = ask(objections)
            self.watch(Step(request.purpose, attempt, attempts))
            return request

        def judge(request: Request, text: str) -> tuple[Answer, list[str]]:
            answer = encode(text)
            if not self.options.validation:
                return answer, []
            self.watch(Step("validation", attempt, attempts))
            return answer, self.validate(request, text)

        return ask_until_accepted(self.model, what, next_request, judge, attempts)

    def validate(self, request: Request, answer: str) -> list[str]:
        """Objections of the self-validator; an answer of its own that cannot be understood is one, too."""
        try:
            reply = self.model.ask(validation_request(self.report, request, answer))
            verdict, problems = encode_verdict(reply.text)
        except AnswerError as error:
            return [f"the validation failed: {error}"]
        if verdict == "Pass":
            return []
        return problems or ["the validator said Fail and no reason"]


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
        AnswerError: a field is missing, unknown, or has a value that the language does not have.
    """
    fields = _object(text, {"analysis", "scenario"})
    try:
        return parse_data(fields["scenario"], "the answer")
    except InputError as error:
        raise AnswerError(f"{error.where}: {error.what}") from None


def encode_verdict(text: str) -> tuple[str, list[str]]:
    """Turn an answer into the validator's verdict and objections.

    Raises:
        AnswerError: it is none.
    """
    fields = _object(text, {"verdict", "problems"})
    verdict, problems = fields["verdict"], fields["problems"]
    if verdict not in {"Pass", "Fail"} or not isinstance(problems, list):
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


def _evidence(scenario: CrashScenario) -> dict[str, FieldEvidence]:
    data = dump_data(scenario)
    values = {name: data[name] for name in ("road_type", "num_lanes", "stem_direction")}
    for index, vehicle in enumerate(data["vehicles"]):
        values |= {f"vehicles[{index}].{name}": value for name, value in vehicle.items()}
    values |= {f"env.{name}": value for name, value in data["env"].items()}
    return {
        name: FieldEvidence(value, None, None, "the model's answer, see the exchanges")
        for name, value in values.items()
    }
