"""Start, spin and stop a node: the part that is the same for every node process."""

import contextlib
import gc
import signal
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from types import FrameType

import rclpy
from rclpy.duration import Duration
from rclpy.exceptions import InvalidParameterTypeException, ParameterException
from rclpy.executors import ExternalShutdownException
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from roadmend.core.errors import InputError, RoadmendError
from roadmend.nodes.fault import leave_fault
from roadmend.nodes.heartbeat import Heartbeat

POLL_S = 0.05  # longest time between two looks at the stop flag [s]
LINGER_S = 0.5  # longest time for which a node that ends waits until its subscribers have what it said [s]


class StopFlag:
    """Set by SIGINT and SIGTERM, or by a node that has finished its work."""

    def __init__(self) -> None:
        self.is_set = False

    def set(self, _signal: int = 0, _frame: FrameType | None = None) -> None:
        """Ask the spin loop to end."""
        self.is_set = True


@contextlib.contextmanager
def stop_on_signals() -> Iterator[StopFlag]:
    """A flag that SIGINT and SIGTERM set while the context lasts.

    rclpy's own handler sometimes misses SIGTERM in this build, hence an own one.
    """
    flag = StopFlag()
    previous = {number: signal.signal(number, flag.set) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield flag
    finally:
        for number, handler in previous.items():
            signal.signal(number, handler)


def run_node(factory: Callable[[], Node], args: Sequence[str] | None = None, *, interrupted: int = 0) -> int:
    """Run one node until it has finished or is told to stop.

    The node may have an attribute ``finished`` (the loop ends when it turns true), an attribute ``exit_code``, an
    attribute ``fault`` (the error because of which that is not 0, or None), an
    attribute ``stop`` (it is given the flag, to look at during long work), an attribute ``linger`` (the longest time [s] for
    which the end waits until subscribers have what was published, LINGER_S without) and a method ``close()`` that is called before
    the node is destroyed, while publishing still works.

    Args:
        factory: makes the node.
        args: the process's, with its name; those it was called with if None.
        interrupted: exit code where the node was told to stop before it had finished; its own if 0.

    Returns:
        Exit code for the process: the node's, or 2 for bad input.
    """
    with stop_on_signals() as stop:
        try:
            rclpy.init(args=list(sys.argv if args is None else args), signal_handler_options=SignalHandlerOptions.NO)
        except RuntimeError as error:  # of rcl: arguments that it cannot read, with the place in its own sources
            what = " ".join(str(error).partition(", at ")[0].split())
            return _refuse(InputError("ROS arguments", what, "correct them"))
        try:
            return _run(factory, stop, interrupted)
        except (ParameterException, InvalidParameterTypeException) as error:
            return _refuse(InputError("ROS arguments", " ".join(str(error).split()), "correct them"))
        except InputError as error:
            return _refuse(error)
        except RoadmendError as error:
            print(f"roadmend: {error}", file=sys.stderr)
            leave_fault(error)
            return 1
        except Exception as error:
            leave_fault(error)
            raise
        finally:
            rclpy.try_shutdown()
            # Say goodbye to DDS now: a forked process ends without the interpreter's own clean-up, and whoever is not
            # told waits for a node that has gone.
            rclpy.get_default_context().destroy()
            gc.unfreeze()
            gc.collect()


def _refuse(error: InputError) -> int:
    if not leave_fault(error):  # a launcher that was told says it itself
        print(f"roadmend: {error}", file=sys.stderr)
    return 2


def _run(factory: Callable[[], Node], stop: StopFlag, interrupted: int) -> int:
    node = factory()
    if hasattr(node, "stop"):
        node.stop = stop
    executor = EventsExecutor()
    executor.add_node(node)
    heartbeat = Heartbeat()
    gc.freeze()  # what is there now stays: the collector need not walk through all of numba again and again
    try:
        # spin() without a time-out never calls back in this build of the executor.
        never: Future[None] = Future()
        while not stop.is_set and not getattr(node, "finished", False):
            heartbeat.beat()
            executor.spin_until_future_complete(never, timeout_sec=POLL_S)
    except (KeyboardInterrupt, ExternalShutdownException):
        pass
    finally:
        close = getattr(node, "close", None)
        if close is not None:
            close()
        _let_arrive(node)
        executor.remove_node(node)
        node.destroy_node()
        executor.shutdown()
    fault = getattr(node, "fault", None)
    if fault is not None:
        leave_fault(fault)
    is_cut = stop.is_set and not getattr(node, "finished", False)
    return int(getattr(node, "exit_code", 0)) or (interrupted if is_cut else 0)


def _let_arrive(node: Node) -> None:
    """Wait until all reliable subscribers have what was published.

    What is under way lies in shared memory that goes with this process, and a loss nobody could repair any more.
    """
    deadline = time.monotonic() + getattr(node, "linger", LINGER_S)
    for publisher in node.publishers if node.context.ok() else ():
        publisher.wait_for_all_acked(Duration(seconds=max(0.0, deadline - time.monotonic())))
