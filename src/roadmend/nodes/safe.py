"""safe_node: an action that reads a crash report and builds the scenarios that it describes."""

import sys
import threading
import types
from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from queue import Empty, SimpleQueue

from rclpy.action import ActionServer, CancelResponse
from rclpy.action.server import ServerGoalHandle
from rclpy.node import Node
from roadmend_msgs.action import BuildCrashScenarios

from roadmend.core.errors import InputError, RoadmendError
from roadmend.language.models import BACKEND_REGISTRY, EMBEDDED
from roadmend.nodes.configuration import ConfigurationAnnouncer
from roadmend.nodes.diagnostics import DiagnosticsReporter, Health, Level
from roadmend.nodes.parameters import declare, declare_name, find_named
from roadmend.nodes.spinning import run_node
from roadmend.safe.backends import BackendOptions, open_extractor
from roadmend.safe.dsl_file import dump_crash_scenario
from roadmend.safe.extraction import Step
from roadmend.safe.report import CrashReport, find_reports, load_report, report_of_text
from roadmend.safe.report_build import PAGE_REGISTRY, ReportBuild, WritePage, build_report
from roadmend.safe.stage_one import StageOneOptions

PAUSE_S = 0.01  # [s] for which a goal waits for its next step before the node's other callbacks have their turn
_PAGE = "roadmend.reports.crash_pages:write_crash_page"
PATIENCE_S = 5.0  # [s] for the step under way when the node is told to stop


class _StoppedError(Exception):
    """The goal was cancelled, or the node is about to end."""


@dataclass(frozen=True)
class _GoalThread:
    """A goal on a thread of its own, seen from the executor's."""

    goal: BuildCrashScenarios.Goal
    steps: SimpleQueue[Step | None] = field(default_factory=SimpleQueue)  # None: it is over
    stop: threading.Event = field(default_factory=threading.Event)
    result: BuildCrashScenarios.Result = field(default_factory=BuildCrashScenarios.Result)

    def watch(self, step: Step) -> None:
        """Called before each step."""
        if self.stop.is_set():
            raise _StoppedError
        self.steps.put(step)


class SafeNode(Node):
    """Reads and builds on threads, one goal at a time; everything of ROS happens on the executor's own."""

    def __init__(self) -> None:
        super().__init__("safe_node")
        self._backend = declare_name(
            self, "backend", EMBEDDED, "what reads a report whose goal names none", BACKEND_REGISTRY
        )
        self._output = Path(declare(self, "output", "crashes", "folder for what is read and built"))
        settings = declare(self, "settings", "", "openai: file like config/language/openai.yaml; the environment wins")
        recording = declare(self, "recording", "", "replay: exchanges of an earlier run, a file or a folder")
        attempts = declare(
            self, "attempts", StageOneOptions().attempts, "openai, replay: executions of a step", low=1, high=20
        )
        self._write_page = self._page_writer(
            declare(self, "page", _PAGE, "what writes the page of a report, as package.module:function, or none")
        )
        self._configuration = ConfigurationAnnouncer(self, "safe")
        self._configuration.announce()
        self._options = BackendOptions(
            StageOneOptions(attempts=attempts),
            Path(settings) if settings else None,
            Path(recording) if recording else None,
        )
        self._turn = threading.Lock()  # there is one SUMO in a process
        self._threads: dict[threading.Thread, _GoalThread] = {}
        self._done = self._failed = 0
        self._server = ActionServer(
            self, BuildCrashScenarios, "~/build", self._execute, cancel_callback=lambda _: CancelResponse.ACCEPT
        )
        self._diagnostics = DiagnosticsReporter(self, self._health)

    def _page_writer(self, name: str) -> WritePage | None:
        """Without the libraries of the usual page there is none; another one that was asked for has to be there."""
        try:
            return find_named("page", name, PAGE_REGISTRY).entry
        except InputError as error:
            if name != _PAGE:
                raise
            self.get_logger().warning(f"no pages are written: {error}")
            return None

    async def _execute(self, handle: ServerGoalHandle) -> BuildCrashScenarios.Result:
        work = _GoalThread(handle.request)
        thread = threading.Thread(target=self._run, args=(work,), daemon=True)
        self._threads[thread] = work
        thread.start()
        while (step := await _next_step(work, handle)) is not None:
            handle.publish_feedback(
                BuildCrashScenarios.Feedback(stage=step.stage, attempt=step.attempt, total=step.total)
            )
        del self._threads[thread]
        if work.result.success:
            self._done += 1
            handle.succeed()
        elif work.stop.is_set():
            work.result.error = "cancelled"
            handle.canceled()
        else:
            self._failed += 1
            self.get_logger().error(work.result.error)
            handle.abort()
        return work.result

    def _run(self, work: _GoalThread) -> None:
        """Do a goal's work; whatever goes wrong becomes its result."""
        try:
            with self._turn:
                _fill(work.result, self._build(work), self._output)
        except _StoppedError:
            pass
        except RoadmendError as error:
            work.result.error = str(error)
        except Exception as error:  # noqa: BLE001 - a fault of ours must not end the node
            work.result.error = " ".join(f"{type(error).__name__}: {error}".split())
        finally:
            work.steps.put(None)

    def _build(self, work: _GoalThread) -> ReportBuild:
        if work.goal.backend != self._backend:
            BACKEND_REGISTRY.find_installed(work.goal.backend or EMBEDDED)  # a client makes the node run no code
        report = _report_of(work.goal)
        extractor = open_extractor(work.goal.backend or self._backend, self._options)
        samples, seed = work.goal.samples, work.goal.seed
        return build_report(report, extractor, self._output, samples, seed, work.watch, self._write_page)

    def _health(self) -> Health:
        values = {"goals done": self._done, "goals failed": self._failed, "goals under way": len(self._threads)}
        return Health(Level.OK, "working" if self._threads else "waiting for goals", values)

    def close(self) -> None:
        """End what is under way after its present step."""
        for work in self._threads.values():
            work.stop.set()
        for thread in self._threads:
            thread.join(PATIENCE_S)
        self._server.destroy()


async def _next_step(work: _GoalThread, handle: ServerGoalHandle) -> Step | None:
    """The next step, None after the last; others have their turn meanwhile."""
    while True:
        if handle.is_cancel_requested:
            work.stop.set()
        try:
            # With a time-out: the executor comes back to a coroutine that waits as fast as it can.
            return work.steps.get(timeout=PAUSE_S)
        except Empty:
            await _others()


@types.coroutine
def _others() -> Generator[None]:
    """Let the executor call back others."""
    yield


def _report_of(goal: BuildCrashScenarios.Goal) -> CrashReport:
    if bool(goal.report) == bool(goal.summary):
        raise InputError("the goal", "has not one of report and summary", "give a path or a text")
    if goal.summary:
        return report_of_text(goal.name or "report", goal.summary)
    reports = find_reports(Path(goal.report))
    if len(reports) > 1:
        raise InputError(goal.report, f"holds {len(reports)} reports", "give the path of one of them")
    return load_report(reports[0])


def _fill(result: BuildCrashScenarios.Result, built: ReportBuild, folder: Path) -> None:
    result.crash = dump_crash_scenario(built.extraction.scenario, ".yaml")
    result.crash_file = str(folder / f"{built.extracted.case}.json")
    result.page = "" if built.page is None else str(built.page)
    result.scenarios = [str(folder / file) for file in built.scenarios]
    result.open_fields = list(built.extracted.open_fields)
    result.notes = [f"sketch: {built.extraction.sketch}", *built.extraction.notes, *built.problems]
    result.error = next(iter(built.problems), "")
    result.success = not built.problems


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until it is stopped."""
    return run_node(SafeNode, args)


if __name__ == "__main__":
    sys.exit(main())
