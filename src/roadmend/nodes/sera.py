"""sera_node: services that find failure patterns in bags and recommend scenarios to learn from."""

import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from rclpy.node import Node
from roadmend_msgs import srv

from roadmend.core.errors import InputError, RoadmendError
from roadmend.language.models import BACKEND_REGISTRY, EMBEDDED
from roadmend.language.question import ATTEMPTS
from roadmend.nodes.configuration import ConfigurationAnnouncer
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.needed import needed
from roadmend.nodes.parameters import declare, declare_name
from roadmend.nodes.pattern_messages import pattern_message_of, patterns_of
from roadmend.nodes.spinning import StopFlag, run_node

with needed():
    from roadmend.sera.analysis import analyse, find_bags, read_incidents
    from roadmend.sera.analysis_report import report
    from roadmend.sera.backends import Backend
    from roadmend.sera.bank import Bank
    from roadmend.sera.recommendation import recommend
    from roadmend.sera.words import words_of

_MOST = 1000  # scenarios a pattern


class SeraNode(Node):
    """Answers one request after another; a long analysis reports the node's health and looks at its end between bags."""

    stop: StopFlag | None = None  # set from outside

    def __init__(self) -> None:
        super().__init__("sera_node")
        bank = declare(self, "bank", "", "scenario bank that is recommended from; without one there is only analysis")
        embedder = declare(
            self, "embedder", "", "embedder that the bank must have been made with; needed where it is code of yours"
        )
        backend = declare_name(self, "backend", EMBEDDED, "who analyses and reflects", BACKEND_REGISTRY)
        settings = declare(self, "settings", "", "YAML file with the endpoint of openai; the environment wins")
        recording = declare(self, "recording", "", "exchanges of an earlier run, for replay")
        exchanges = declare(self, "exchanges", "", "file that what a language model is asked is added to")
        attempts = declare(
            self, "attempts", ATTEMPTS, "answers that a question to a language model may take", low=1, high=20
        )
        self._count: int = declare(
            self, "count", 8, "scenarios a pattern where the request does not say", low=1, high=_MOST
        )
        self._configuration = ConfigurationAnnouncer(self, "sera")
        self._configuration.announce()
        self._exchanges = Path(exchanges) if exchanges else None
        self._backend = Backend.open(
            backend, Path(settings) if settings else None, Path(recording) if recording else None, attempts
        )
        if self._backend.model is not None and self._exchanges is None:
            raise InputError(f"backend {backend}", "has no place for what is said", "set the parameter exchanges")
        self._bank = Bank(Path(bank), embedder or None) if bank else None
        self._work = ""  # at hand
        self._answered = 0
        self._failure = ""
        self.create_service(srv.AnalyseBag, "~/analyse_bag", self._on_analyse)
        self.create_service(srv.Recommend, "~/recommend", self._on_recommend)
        self._diagnostics = DiagnosticsReporter(self, self._health)

    def _on_analyse(
        self, request: srv.AnalyseBag.Request, response: srv.AnalyseBag.Response
    ) -> srv.AnalyseBag.Response:
        return self._answer(self._analyse, request, response)

    def _on_recommend(self, request: srv.Recommend.Request, response: srv.Recommend.Response) -> srv.Recommend.Response:
        return self._answer(self._recommend, request, response)

    def _answer(self, work: Callable[[Any, Any], None], request: Any, response: Any) -> Any:
        try:
            self._at_work("at work")
            work(request, response)
            self._failure = ""
        except RoadmendError as error:
            self._failure = str(error)
        except Exception as error:  # noqa: BLE001 - a request that cannot be answered must not end the node
            self._failure = f"{type(error).__name__}: {error}"
        self._keep_exchanges()
        if self._failure:
            self.get_logger().error(self._failure)
            response = type(response)(success=False, message=self._failure)
        self._work = ""
        self._answered += 1
        return response

    def _at_work(self, what: str) -> None:
        if self.stop is not None and self.stop.is_set:
            raise RoadmendError("interrupted")
        self._work = what
        self._diagnostics.publish()  # its timer has no turn before the answer

    def _analyse(self, request: srv.AnalyseBag.Request, response: srv.AnalyseBag.Response) -> None:
        if not request.bags:
            raise InputError("bags", "there is none", "name bags, or folders with bags in them")
        readings = []
        for bag in find_bags(Path(each) for each in request.bags):
            self._at_work(f"reading {bag}")
            readings.append(read_incidents(bag))
        analysis = analyse(readings, self._backend.analyser)
        response.patterns = [pattern_message_of(pattern) for pattern in analysis.patterns]
        response.unreadable = [each.problem for each in analysis.unreadable]
        response.report = report(analysis)
        response.success = not analysis.unreadable
        response.message = (
            f"{len(analysis.bags)} bags read, {len(analysis.unreadable)} unreadable, "
            f"{len(analysis.incidents)} incidents, {len(analysis.patterns)} patterns"
        )

    def _recommend(self, request: srv.Recommend.Request, response: srv.Recommend.Response) -> None:
        if self._bank is None:
            raise InputError("parameter bank", "names no bank", "start the node with one")
        if request.count > _MOST:
            raise InputError("count", f"{request.count} is too many", f"ask for at most {_MOST} a pattern")
        found = recommend(
            self._bank,
            patterns_of(request.patterns),
            request.count or self._count,
            exclude=request.exclude,
            reflector=self._backend.reflector,
        )
        entries = [self._bank.entry(pick.number) for pick in found.refined]
        response.name = [entry.name for entry in entries]
        response.digest = [entry.digest for entry in entries]
        response.pattern = [pick.pattern for pick in found.refined]
        response.score = [pick.score for pick in found.refined]
        response.words = [words_of(entry.descriptor) for entry in entries]
        response.swaps = [swap.reason for swap in found.swaps]
        response.missing = found.missing
        response.success = True
        response.message = f"{len(entries)} scenarios, {len(found.swaps)} swaps, {found.missing} places empty"

    def _keep_exchanges(self) -> None:
        model = self._backend.model
        if model is None or self._exchanges is None or not model.exchanges:
            return
        try:
            with self._exchanges.open("a", encoding="utf-8") as file:
                file.write(self._backend.exchanges())
            model.exchanges.clear()
        except OSError as error:
            self.get_logger().error(f"{self._exchanges}: cannot be written ({error.strerror})")

    def _health(self) -> Health:
        values = {"answered": self._answered, "scenarios": len(self._bank or ())}
        if self._work:
            return Health(Level.OK, self._work, values)
        if self._failure:
            return Health(Level.WARN, f"the last request failed: {self._failure}", values)
        return Health(Level.OK, "waiting for requests", values)

    def close(self) -> None:
        """Let go of the bank."""
        if self._bank is not None:
            self._bank.close()


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is stopped."""
    return run_node(SeraNode, args)


if __name__ == "__main__":
    sys.exit(main())
