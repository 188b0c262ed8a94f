"""Stage I of SAFE with a language model: algorithm 1 of the paper, and every answer held against what is known without it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from roadmend.core.errors import ForeignError
from roadmend.language.chat import AnswerError, ChatModel, LanguageError, Request
from roadmend.language.endpoint_habits import PICTURES
from roadmend.language.exchange import RecordingModel
from roadmend.language.question import ATTEMPTS, ask_until_accepted
from roadmend.safe.answer_check import AnswerCheck, FieldCheck, unchecked
from roadmend.safe.dsl import RoadType
from roadmend.safe.embedded import EmbeddedExtractor
from roadmend.safe.encoder import MetaMessage, encode_meta, encode_scenario, encode_verdict
from roadmend.safe.extraction import Extraction, ExtractionError, Extractor, FieldEvidence, Step, Watch, unwatched
from roadmend.safe.knowledge_base import retrieve
from roadmend.safe.prompts import extraction_request, meta_request, validation_request
from roadmend.safe.report import CrashReport
from roadmend.safe.settlement import settle

Answer = TypeVar("Answer")


@dataclass(frozen=True, slots=True)
class StageOneOptions:
    """What can be switched off to see what it is good for.

    Attributes:
        prompt_generation: ask with the template and the example that the knowledge base has for such a road.
        validation: let the model check each answer against the report.
        cross_check: hold each answer against the embedded reader, the meta message and the geometry of the scene.
        attempts: how often a step is executed before the report is given up.
    """

    prompt_generation: bool = True
    validation: bool = True
    cross_check: bool = True
    attempts: int = ATTEMPTS


class LanguageExtractor:
    """Extracts with a language model.

    Args:
        model: that answers.
        options: see ``StageOneOptions``.
        reader: that needs no model, which answers are held against.
    """

    def __init__(self, model: ChatModel, options: StageOneOptions, reader: Extractor | None = None) -> None:
        self.model = model
        self.options = options
        self.reader = reader or EmbeddedExtractor()

    def extract(self, report: CrashReport, watch: Watch = unwatched) -> Extraction:
        """Extract one report.

        Raises:
            ExtractionError: the model gave no answer, or none that passed, as often as it was asked.
        """
        model = RecordingModel(self.model)
        steps = _CheckedSteps(model, report, self.options, watch)
        check = self._check(report, watch) if self.options.cross_check else None
        meta, found = None, None
        try:
            if self.options.prompt_generation:
                _, example = retrieve(RoadType.T_INTERSECTION, ())
                meta = steps.run(
                    "the meta message",
                    lambda objections: meta_request(report, example, objections),
                    encode_meta,
                    check.of_meta if check is not None else _undoubted,
                )
                found = retrieve(_road_type(meta, check), meta.directions)
            scenario = steps.run(
                "the scenario",
                lambda objections: extraction_request(report, found, objections),
                encode_scenario,
                partial(check.of_scenario, meta=meta) if check is not None else _undoubted,
            )
        except LanguageError as error:
            raise ExtractionError(str(error), tuple(model.exchanges)) from None
        except ForeignError as error:  # what was answered before may have cost money
            raise ExtractionError(str(error), tuple(model.exchanges)) from error
        checks = check.of_scenario(scenario, meta) if check is not None else [*unchecked(scenario)]
        settled, evidence = settle(scenario, checks, check.reading if check is not None else None, report.summary)
        notes = (*report.notes, *self._notes(check, evidence))
        return Extraction(settled, evidence, _sketch(report, model), notes, tuple(model.exchanges))

    def _check(self, report: CrashReport, watch: Watch) -> AnswerCheck:
        try:
            return AnswerCheck(report, self.reader.extract(report, watch))
        except ExtractionError as error:
            return AnswerCheck(report, None, str(error))

    def _notes(self, check: AnswerCheck | None, evidence: Mapping[str, FieldEvidence]) -> Iterator[str]:
        if not self.options.prompt_generation:
            yield "asked without the knowledge base"
        if not self.options.validation:
            yield "answers were not validated"
        if check is None:
            yield "answers were not cross-checked"
        elif check.reading is None:
            yield f"answers were cross-checked without the embedded reader: {check.unread}"
        disputed = [name for name, found in evidence.items() if found.disputed]
        if disputed:
            yield f"disputed: {', '.join(disputed)}"


def _road_type(meta: MetaMessage, check: AnswerCheck | None) -> RoadType:
    """By which to look into the knowledge base: the likeliest one."""
    doubted = check.of_meta(meta) if check is not None else ()
    return next((RoadType(each.kept) for each in doubted if each.field == "road_type"), meta.road_type)


def _undoubted(_: object) -> list[FieldCheck]:
    return []


def _sketch(report: CrashReport, model: RecordingModel) -> str:
    if report.sketch is None:
        return "there is none"
    replies = [exchange.reply for exchange in model.exchanges if exchange.reply is not None]
    if any(PICTURES in reply.left_out for reply in replies):
        return "not read: the endpoint did not take the picture, the model was asked with the summary alone"
    return "read: sent to the model beside the summary"


class _CheckedSteps:
    """Executes a step until its answer can be encoded, stands up to what is known, and passes, within a bound."""

    def __init__(self, model: ChatModel, report: CrashReport, options: StageOneOptions, watch: Watch) -> None:
        self.model = model
        self.report = report
        self.options = options
        self.watch = watch

    def run(
        self,
        what: str,
        ask: Callable[[Sequence[str]], Request],
        encode: Callable[[str], Answer],
        doubt: Callable[[Answer], list[FieldCheck]],
    ) -> Answer:
        """The answer to a step.

        A model that stays by a doubted answer although it was told the reason is not asked for ever: the answer goes on
        to the validation, and the doubt into the result.
        """
        attempt, attempts = 0, self.options.attempts
        told: list[str] = []

        def next_request(objections: Sequence[str]) -> Request:
            nonlocal attempt
            attempt += 1
            request = ask(objections)
            self.watch(Step(request.purpose, attempt, attempts))
            return request

        def judge(request: Request, text: str) -> tuple[Answer, list[str]]:
            nonlocal told
            answer = encode(text)
            doubts = [objection for check in doubt(answer) if (objection := check.objection()) is not None]
            if doubts and doubts != told and attempt < attempts:
                told = doubts
                return answer, doubts
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
