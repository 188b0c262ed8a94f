"""repair_node in this process: every fault has its answer, its name, and a way out."""

import itertools
import json
import math
import time
from types import SimpleNamespace

import numpy as np
import pytest
import rclpy
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from nav_msgs.msg import Odometry
from rclpy.experimental import EventsExecutor
from rclpy.lifecycle import TransitionCallbackReturn
from rclpy.node import Node
from rclpy.parameter import Parameter
from roadmend_msgs import msg

from roadmend.core.command import Command, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.outcome import Event, EventKind
from roadmend.core.repair import RepairStatus
from roadmend.core.route import Route, Stage
from roadmend.core.scene import EgoState, ObjectList
from roadmend.nodes import qos
from roadmend.nodes import repair as module
from roadmend.nodes.diagnostics import Level
from roadmend.recording import messages, topics
from roadmend.recording.codec import encode
from roadmend.repair.rule import RuleRepair

PARTS = ("ego", "objects", "trajectory", "command")
STOP = -0.5  # action of a controlled stop


class Tape:
    """Stands before a publisher and keeps what it lets through."""

    def __init__(self, publisher, kind):
        self._publisher, self._kind, self.got = publisher, kind, []

    def publish(self, data):
        if self._publisher.is_activated:
            self.got.append(self._kind.decode(data))


class Bench:
    """A repair node whose inputs and whose wall clock are in the test's hands."""

    def __init__(self, node, clock):
        self.node, self.clock = node, clock
        self.commands = node._command_publisher = Tape(node._command_publisher, messages.COMMAND)
        self.states = node._state_publisher = Tape(node._state_publisher, messages.REPAIR)

    def route(self, **changes):
        x = np.linspace(0.0, 500.0, 11)
        stage = Stage(x, 0.0 * x, np.full(11, 15.0))
        message = messages.route_message_of(
            Route("test", 4.7, 1.85, 480.0, 60.0, (stage,), (), ()), messages.header_of(0.0)
        )
        for name, value in changes.items():
            setattr(message, name, value)
        self.node._on_route(encode(message))

    def send(self, number, *parts, command=None, objects=None, speed=10.0, ego=None):
        header = messages.header_of(0.05 * number)
        for part in parts:
            if part == "ego":
                ego = ego or EgoState.from_yaw(50.0 + 0.5 * number, 0.0, 0.0, speed, 0.0, 4.7, 1.85)
                message = messages.ego_message_of(ego, header)
            elif part == "objects":
                message = objects_message(objects or []) if isinstance(objects, list | None) else objects
                message.header = header
            elif part == "command":
                message = messages.command_message_of(command or Command(0.2, 0.0), header)
            else:
                message = messages.trajectory_message_of(Trajectory.empty(), header)
            self.node._add(part, encode(message))

    def tick(self, number, without=(), **what):
        """One tick of all inputs but some; returns the states said meanwhile."""
        before = len(self.states.got)
        self.send(number, *(part for part in PARTS if part not in without), **what)
        return self.states.got[before:]

    def wait(self, duration):
        """Let wall time pass; returns the states said meanwhile."""
        before = len(self.states.got)
        for _ in range(round(duration / 0.01)):
            self.clock.now += 0.01
            self.node._watch()
        return self.states.got[before:]

    def start(self, ticks=2):
        self.route()
        for number in range(ticks):
            self.tick(number)
        assert self.states.got[-1].state == RepairStatus.PASS

    @property
    def health(self):
        return self.node._health()


def objects_message(rows):
    """Rows of (id, x, y, speed, length)."""
    columns = np.array(rows, dtype=np.float64).reshape(-1, 5).T
    objects = ObjectList.of(
        id=columns[0],
        kind=1,
        x=columns[1],
        y=columns[2],
        yaw=0.0,
        speed=columns[3],
        acceleration=0.0,
        yaw_rate=0.0,
        length=columns[4],
        width=1.8,
    )
    return messages.object_message_of(objects, np.empty(0, dtype=np.uint8), messages.header_of(0.0))


@pytest.fixture
def bench(domain, tmp_path, monkeypatch):
    """Makes a node with parameters; at its end all is gone."""
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    clock = SimpleNamespace(now=1000.0)
    made = []

    def make(**parameters):
        words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={json.dumps(value)}")]
        rclpy.init(args=["test", "--ros-args", *words], domain_id=domain)
        node = module.RepairNode()
        made.append(node)
        monkeypatch.setattr(module, "time", SimpleNamespace(monotonic=lambda: clock.now))
        return Bench(node, clock)

    yield make
    for node in made:
        node.destroy_node()
    rclpy.try_shutdown()


def state_of(node):
    return node._state_machine.current_state[1]


def consistent(bench):
    """Every state has its command: same stamp, same action, and a valid one."""
    for state, command in zip(bench.states.got, bench.commands.got, strict=True):
        assert state.header.stamp == command.header.stamp
        assert state.final_action == command.throttle - command.brake
        assert messages.command_of(command).fault == ""
    return True


# -- life cycle --------------------------------------------------------------------------------------------------------


def test_it_goes_through_every_transition_and_answers_only_while_active(bench):
    there = bench(autostart=False)
    node = there.node
    assert state_of(node) == "unconfigured"
    for transition, state, answers in (
        (node.trigger_configure, "inactive", False),
        (node.trigger_activate, "active", True),
        (node.trigger_deactivate, "inactive", False),
        (node.trigger_activate, "active", True),
        (node.trigger_deactivate, "inactive", False),
        (node.trigger_cleanup, "unconfigured", False),
        (node.trigger_configure, "inactive", False),
        (node.trigger_activate, "active", True),
        (node.trigger_shutdown, "finalized", False),
    ):
        assert transition() == TransitionCallbackReturn.SUCCESS
        assert state_of(node) == state
        there.route()
        said = there.tick(0) + there.tick(1) + there.wait(5.0)
        assert bool(said) == answers, transition
        assert (there.health.level is Level.WARN) == (not answers)
    assert consistent(there)


STATES = {  # and how to get there from unconfigured
    "unconfigured": (),
    "inactive": ("configure",),
    "active": ("configure", "activate"),
    "finalized": ("shutdown",),
}
POSSIBLE = {  # transition asked for over the service -> state in which it can be made -> state to which it leads
    Transition.TRANSITION_CONFIGURE: {"unconfigured": "inactive"},
    Transition.TRANSITION_CLEANUP: {"inactive": "unconfigured"},
    Transition.TRANSITION_ACTIVATE: {"inactive": "active"},
    Transition.TRANSITION_DEACTIVATE: {"active": "inactive"},
    Transition.TRANSITION_UNCONFIGURED_SHUTDOWN: {"unconfigured": "finalized"},
    Transition.TRANSITION_INACTIVE_SHUTDOWN: {"inactive": "finalized"},
    Transition.TRANSITION_ACTIVE_SHUTDOWN: {"active": "finalized"},
}
IMPOSSIBLE = (0, 8, 9, 10, 60, 99, 255)  # create, destroy, what callbacks return, and what is no transition at all


def put_away(executor, *nodes):
    for one in nodes:
        executor.remove_node(one)
        one.destroy_node()
    executor.shutdown()
    rclpy.try_shutdown()


@pytest.mark.parametrize("state", STATES)
def test_every_transition_in_every_state_is_made_or_refused_over_the_service_and_the_node_stays(
    domain, tmp_path, state
):
    rclpy.init(args=["test", "--ros-args", "-p", "autostart:=false"], domain_id=domain)
    executor = EventsExecutor()
    node, other = module.RepairNode(), Node("operator")
    client = other.create_client(ChangeState, "/repair_node/change_state")

    def ask(number=0, label=""):
        request = ChangeState.Request(transition=Transition(id=number, label=label))
        future = client.call_async(request)
        executor.spin_until_future_complete(future, timeout_sec=60.0)
        return future.result().success

    def reset():
        """Back to the state: from finalized there is no way, and none is needed."""
        for _ in range(3):
            way = {"active": "deactivate", "inactive": "cleanup"}.get(state_of(node))
            if state_of(node) != state and way:
                assert ask(label=way)
        for label in STATES[state] if state_of(node) == "unconfigured" else ():
            assert ask(label=label)
        assert state_of(node) == state

    try:
        for one in (node, other):
            executor.add_node(one)
        assert client.wait_for_service(timeout_sec=60.0)
        refused = [number for number in POSSIBLE if state not in POSSIBLE[number]]
        for number in (*refused, *IMPOSSIBLE):
            reset()
            assert not ask(number), number
            assert state_of(node) == state, number
        assert not ask(label="fly")
        for number in [number for number in POSSIBLE if state in POSSIBLE[number]]:
            goal = POSSIBLE[number][state]
            reset()
            if goal == "finalized":
                continue  # last, since there is no way back
            assert ask(number), number
            assert state_of(node) == goal
        reset()
        assert ask(label="shutdown") == (state != "finalized")
        assert state_of(node) == "finalized"
        assert not ask(Transition.TRANSITION_CONFIGURE)
    finally:
        put_away(executor, node, other)


def test_a_method_that_breaks_while_it_is_made_is_a_refusal_too(bench, monkeypatch, capfd):
    there = bench(autostart=False)
    monkeypatch.setattr(module, "make_method", lambda *_: 1 / 0)
    assert there.node.trigger_configure() == TransitionCallbackReturn.FAILURE
    assert state_of(there.node) == "unconfigured"
    assert "refuses to configure: ZeroDivisionError: division by zero" in capfd.readouterr().err
    monkeypatch.undo()
    assert there.node.trigger_configure() == TransitionCallbackReturn.SUCCESS


def test_by_default_it_starts_by_itself(bench):
    assert state_of(bench().node) == "active"


def test_a_method_that_cannot_be_made_is_a_refusal_to_configure(bench, monkeypatch, capfd):
    def broken(*_):
        raise InputError("model.safetensors", "no such file", "train one")

    there = bench(autostart=False)
    monkeypatch.setattr(module, "make_method", broken)
    assert there.node.trigger_configure() == TransitionCallbackReturn.FAILURE
    assert state_of(there.node) == "unconfigured"
    assert "refuses to configure: model.safetensors: no such file; train one" in capfd.readouterr().err
    there.route()
    assert there.tick(0) == [] == there.wait(5.0)
    monkeypatch.undo()
    assert there.node.trigger_configure() == TransitionCallbackReturn.SUCCESS


def test_a_missing_model_is_a_refusal_to_configure(bench, tmp_path, capfd):
    path = str(tmp_path / "none.safetensors")
    there = bench(autostart=False, method="adreft", **{"adreft.model": path})
    assert there.node.trigger_configure() == TransitionCallbackReturn.FAILURE
    assert state_of(there.node) == "unconfigured"
    assert f"refuses to configure: {path}: no such model file" in capfd.readouterr().err
    there.route()
    assert there.tick(0) == [] == there.wait(5.0)


def test_a_model_that_is_damaged_is_a_refusal_to_configure(bench, tmp_path, capfd):
    path = tmp_path / "broken.safetensors"
    path.write_bytes(b"no model")
    there = bench(autostart=False, method="adreft", **{"adreft.model": str(path)})
    assert there.node.trigger_configure() == TransitionCallbackReturn.FAILURE
    assert "cut or damaged" in capfd.readouterr().err


def test_a_refusal_under_autostart_ends_the_node_with_the_code_for_bad_input(bench, monkeypatch):
    monkeypatch.setattr(module, "make_method", lambda *_: (_ for _ in ()).throw(InputError("a", "b", "c")))
    node = bench().node
    assert (node.finished, node.exit_code, state_of(node)) == (True, 2, "unconfigured")


@pytest.mark.parametrize(
    "parameter", ["rss.rho:=-1.0", "rss.rho:=fast", "method:=prayer", "time_budget:=-1.0", "seed:=-1"]
)
def test_a_bad_parameter_ends_the_process_with_code_2_and_one_line(parameter, domain, tmp_path, monkeypatch, capfd):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    assert module.main(["repair_node", "--ros-args", "-p", parameter]) == 2
    complaint = capfd.readouterr().err.splitlines()
    assert len(complaint) == 1
    assert complaint[0].startswith(f"roadmend: parameter {parameter.partition(':')[0]}: ")
    assert "; " in complaint[0]


def test_the_tally_is_written_at_the_end(bench, tmp_path):
    there = bench(summary=str(tmp_path / "repair.json"))
    there.start(5)
    there.node.close()
    told = json.loads((tmp_path / "repair.json").read_text())
    assert told["answers"] == 5
    assert told["state.RESET"] == 1
    assert told["state.PASS"] == 4


# -- parameters at run time --------------------------------------------------------------------------------------------


def test_a_parameter_of_the_method_can_be_changed_at_run_time(bench):
    there = bench()
    there.start()
    result = there.node.set_parameters([Parameter("rss.rho", value=1.5)])[0]
    assert result.successful
    assert there.node._repairer._method._parameters.rho == 1.5
    assert [state.state for state in there.tick(2)] == [RepairStatus.RESET]  # it has the route, and begins anew on it
    assert [state.state for state in there.tick(3)] == [RepairStatus.PASS]


@pytest.mark.parametrize("method", ["rule", "rss", "predictive", "gated"])
def test_guard_and_method_reckon_with_the_vehicles_full_brake_unless_the_methods_own_is_given(bench, method):
    node = bench(method=method, full_brake=6.0).node
    assert node._repairer.parameters.full_brake == node.get_parameter(f"{method}.full_brake").value == 6.0
    node.set_parameters([Parameter(f"{method}.full_brake", value=7.0)])
    assert node.get_parameter(f"{method}.full_brake").value == 7.0
    assert node._repairer.parameters.full_brake == 6.0


def test_a_methods_own_full_brake_comes_before_the_vehicles(bench):
    node = bench(method="rss", full_brake=6.0, **{"rss.full_brake": 9.0}).node
    assert node._made._parameters.full_brake == 9.0


@pytest.mark.parametrize(
    ("parameter", "value", "reason"),
    [
        ("rss.rho", -1.0, "out of range"),
        ("rss.rho", 3.1, "out of range"),
        ("rss.rho", math.nan, ""),
        ("rss.rho", "fast", "type"),
        ("method", "none", "read-only"),
        ("clock", "realtime", "read-only"),
    ],
)
def test_a_bad_value_at_run_time_is_refused_with_a_reason_and_changes_nothing(bench, parameter, value, reason):
    there = bench()
    there.start()
    before = there.node._repairer
    result = there.node.set_parameters([Parameter(parameter, value=value)])[0]
    assert not result.successful
    assert result.reason
    assert reason in result.reason
    assert there.node._repairer is before
    assert there.node.get_parameter("rss.rho").value == 0.5
    assert [state.state for state in there.tick(2)] == [RepairStatus.PASS]


def test_parameters_of_a_method_that_does_not_run_disturb_nothing(bench):
    there = bench()
    before = there.node._repairer
    assert there.node.set_parameters([Parameter("rule.time_to_collision", value=2.0)])[0].successful
    assert there.node._repairer is before


# -- a tick ------------------------------------------------------------------------------------------------------------


def test_a_good_command_goes_through_untouched(bench):
    there = bench()
    there.route()
    there.tick(0)
    assert there.states.got[0].state == RepairStatus.RESET  # a new episode
    (state,) = there.tick(1, command=Command(0.37, 0.0, change_lane=True))
    assert (state.state, state.intervened, state.final_action) == (RepairStatus.PASS, False, 0.37)
    assert there.commands.got[-1].change_lane
    assert there.health.level is Level.OK


def test_a_dangerous_command_is_repaired_and_the_state_names_why(bench):
    there = bench()
    there.start()
    (state,) = there.tick(2, objects=[(7, 62.0, 0.0, 0.0, 4.0)])
    assert (state.state, state.intervened, list(state.trigger_id)) == (RepairStatus.REPAIRED, True, [7])
    assert state.final_action < -0.5
    assert "object 7" in state.reason
    assert consistent(there)


@pytest.mark.parametrize("objects", [[], [(7, 62.0, 0.0, 0.0, 4.0)]])
def test_a_tick_sent_twice_gets_the_same_answer_and_counts_once(bench, objects):
    there = bench()
    there.start()
    first = there.tick(2, objects=objects)
    again = there.tick(2, objects=objects)
    assert len(first) == len(again) == 1
    assert encode(first[0]) == encode(again[0])
    assert there.node._tally.values()["answers"] == 3


def test_before_the_route_nothing_is_answered_because_the_simulator_repeats(bench):
    there = bench()
    assert there.tick(0) == []
    there.route()
    assert [state.state for state in there.tick(0)] == [RepairStatus.RESET]


@pytest.mark.parametrize(
    "order", [("command", "trajectory", "objects", "ego"), ("objects", "command", "ego", "trajectory")]
)
def test_the_order_in_which_a_tick_arrives_does_not_matter(bench, order):
    there = bench()
    there.start()
    there.send(2, *order, objects=[(7, 62.0, 0.0, 0.0, 4.0)])
    other = there.tick(3, objects=[(7, 62.5, 0.0, 0.0, 4.0)])
    assert [state.state for state in there.states.got[-2:]] == [RepairStatus.REPAIRED] * 2
    assert other[0].final_action == there.states.got[-2].final_action


# -- faults ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("missing", [("command",), ("trajectory",), ("command", "trajectory")])
def test_a_missing_command_is_a_controlled_stop_until_commands_come_again(bench, missing):
    there = bench()
    there.start()
    assert there.tick(2, without=missing) == []
    assert there.wait(1.9) == []
    (state,) = there.wait(0.2)
    assert (state.state, state.final_action, state.intervened) == (RepairStatus.STALE_COMMAND, STOP, True)
    assert all(part in state.reason for part in missing)
    assert (there.health.level, there.commands.got[-1].throttle) == (Level.ERROR, 0.0)
    for number in range(3, 8):  # while it is known to be silent there is no waiting of two seconds
        there.tick(number, without=missing)
        assert [state.state for state in there.wait(0.03)] == [RepairStatus.STALE_COMMAND]
    (state,) = there.tick(8)
    assert (state.state, state.final_action) == (RepairStatus.PASS, 0.2)
    assert there.health.level is Level.OK
    assert there.tick(9, without=missing) == there.wait(1.9) == []  # patient again
    assert consistent(there)


def test_a_command_that_comes_after_its_tick_was_answered_is_not_obeyed(bench):
    there = bench()
    there.start()
    there.tick(2, without=("command",))
    assert len(there.wait(2.1)) == 1
    before = len(there.commands.got)
    there.send(2, "command")
    there.wait(1.0)
    assert len(there.commands.got) == before


@pytest.mark.parametrize("missing", [("objects",), ("ego",), ("ego", "objects")])
def test_missing_objects_or_odometry_are_a_controlled_stop_until_they_come_again(bench, missing):
    there = bench()
    there.start()
    there.tick(2, without=missing)
    (state,) = there.wait(2.1)
    assert (state.state, state.final_action) == (RepairStatus.STALE_OBJECTS, STOP)
    assert all(part in state.reason for part in missing)
    assert there.health.level is Level.ERROR
    (state,) = there.tick(3)
    assert state.state == RepairStatus.PASS
    assert consistent(there)


def test_a_stop_brakes_harder_than_usual_where_somebody_is_close(bench):
    there = bench()
    there.start()
    there.tick(2, without=("command",), objects=[(7, 62.0, 0.0, 0.0, 4.0)])
    (state,) = there.wait(2.1)
    assert state.state == RepairStatus.STALE_COMMAND
    assert -1.0 <= state.final_action < STOP
    assert "rss" in state.reason


def test_a_stop_never_brakes_less_than_the_policy_asked(bench):
    there = bench()
    there.start()
    there.tick(2, without=("objects",), command=Command(0.0, 0.9))
    (state,) = there.wait(2.1)
    assert (state.state, state.final_action, state.intervened) == (RepairStatus.STALE_OBJECTS, -0.9, False)


@pytest.mark.parametrize(
    "command",
    [
        Command(math.nan, 0.0),
        Command(0.0, math.nan),
        Command(math.inf, 0.0),
        Command(0.0, math.inf),
        Command(0.5, 0.5),
        Command(1.01, 0.0),
        Command(-0.01, 0.0),
        Command(0.0, 1.01),
        Command(0.0, -0.01),
    ],
)
def test_an_invalid_command_is_sanitised_and_never_reaches_the_vehicle(bench, command):
    there = bench()
    there.start()
    (state,) = there.tick(2, command=command)
    assert state.state == RepairStatus.INVALID_COMMAND
    sent = messages.command_of(there.commands.got[-1])
    assert sent.fault == ""
    assert sent.throttle <= (command.throttle if math.isfinite(command.throttle) else 0.0) or sent.throttle == 0.0
    assert state.reason
    assert there.health.level is Level.WARN
    assert [state.state for state in there.tick(3)] == [RepairStatus.PASS]


def test_bad_objects_are_dropped_and_counted_and_the_rest_is_used(bench):
    there = bench()
    there.start()
    rows = [
        (1, math.nan, 0.0, 0.0, 4.0),
        (7, 62.0, 0.0, 0.0, 4.0),
        (7, 90.0, 0.0, 0.0, 4.0),
        (3, 80.0, 0.0, 0.0, -4.0),
        (4, 90.0, 3.0, math.inf, 4.0),
    ]
    (state,) = there.tick(2, objects=rows)
    assert (state.state, state.dropped_objects) == (RepairStatus.INVALID_OBJECTS, 4)
    assert list(state.trigger_id) == [7]
    assert state.final_action < -0.5
    assert there.health.level is Level.WARN


def test_more_objects_than_ever_seen_are_all_looked_at(bench):
    there = bench()
    there.start()
    far = [(100 + number, 5000.0 + 10.0 * number, 300.0, 0.0, 4.0) for number in range(3000)]
    (state,) = there.tick(2, objects=[*far, (7, 62.0, 0.0, 0.0, 4.0)])
    assert (state.state, state.dropped_objects, list(state.trigger_id)) == (RepairStatus.REPAIRED, 0, [7])


def test_objects_whose_arrays_do_not_fit_are_as_good_as_none(bench):
    there = bench()
    there.start()
    message = objects_message([(7, 62.0, 0.0, 0.0, 4.0)])
    message.speed = np.array([1.0, 2.0])
    (state,) = there.tick(2, objects=message)
    assert (state.state, state.final_action) == (RepairStatus.STALE_OBJECTS, STOP)
    assert "differ in length" in state.reason


@pytest.mark.parametrize("part", PARTS)
@pytest.mark.parametrize("size", [0, 4, 11])
def test_bytes_that_are_too_few_for_a_header_are_as_good_as_none(bench, capfd, part, size):
    there = bench()
    there.start()
    there.tick(2, without=(part,))
    there.node._add(part, encode(messages.COMMAND(header=messages.header_of(0.1)))[:size])
    assert len(there.states.got) == 2
    assert f"unusable: {part}: {size} bytes are too few for a header" in capfd.readouterr().err
    (state,) = there.wait(2.1)
    expected = RepairStatus.STALE_OBJECTS if part in {"ego", "objects"} else RepairStatus.STALE_COMMAND
    assert (state.state, state.final_action) == (expected, STOP)
    assert [state.state for state in there.tick(3)] == [RepairStatus.PASS]


@pytest.mark.parametrize("part", PARTS)
def test_a_message_in_another_frame_is_as_good_as_none_and_named(bench, part):
    there = bench()
    there.start()
    there.tick(2, without=(part,))
    made = {
        "ego": lambda at: messages.ego_message_of(EgoState.from_yaw(1.0, 0.0, 0.0, 5.0, 0.0, 4.7, 1.85), at),
        "objects": lambda at: messages.OBJECTS(header=at),
        "command": lambda at: messages.command_message_of(Command(0.2, 0.0), at),
        "trajectory": lambda at: messages.trajectory_message_of(Trajectory.empty(), at),
    }[part]
    header = messages.header_of(0.1)
    there.node._add(part, encode(made(messages.HEADER(stamp=header.stamp, frame_id="odom"))))
    assert len(there.states.got) == 2
    assert (there.health.level, f"{part} in 'odom'" in there.health.message) == (Level.WARN, True)
    (state,) = there.wait(2.1)
    assert (state.final_action, f"no {part} within" in state.reason) == (STOP, True)
    assert "not in the frame 'map'" in there.health.message
    there.node._add(part, encode(made(messages.HEADER(stamp=messages.header_of(0.15).stamp, frame_id=""))))
    (state,) = there.tick(3, without=(part,))  # one that names no frame is taken to be in the right one
    assert state.state == RepairStatus.PASS
    assert there.health.level is Level.OK


def test_odometry_that_is_not_finite_is_as_good_as_none(bench):
    there = bench()
    there.start()
    (state,) = there.tick(2, ego=EgoState.from_yaw(math.nan, 0.0, 0.0, 5.0, 0.0, 4.7, 1.85))
    assert (state.state, state.final_action) == (RepairStatus.STALE_OBJECTS, STOP)


@pytest.mark.parametrize("to", [0, 2])
def test_stamps_that_run_backwards_reset_the_method_and_are_answered(bench, to):
    there = bench()
    there.start(6)
    (state,) = there.tick(to)
    assert state.state == RepairStatus.RESET
    assert "memory cleared" in state.reason
    assert [state.state for state in there.tick(to + 1)] == [RepairStatus.PASS]


def test_a_clock_that_jumps_ahead_resets_the_method(bench):
    there = bench()
    there.start()
    assert [state.state for state in there.tick(100)] == [RepairStatus.RESET]


def test_a_new_route_begins_a_new_episode(bench):
    there = bench()
    there.start(6)
    there.tick(6, without=("command",))  # never answered
    there.route()
    assert there.wait(5.0) == []  # the simulator repeats the first tick
    assert [state.state for state in there.tick(0)] == [RepairStatus.RESET]


def test_a_broken_route_is_reported_and_nothing_is_driven_on_it(bench):
    there = bench()
    there.start()
    there.route(y=np.array([0.0, 1.0]))
    assert there.health.level is Level.ERROR
    assert "differ in length" in there.health.message
    assert there.tick(0) == [] == there.wait(5.0)
    there.route()
    assert [state.state for state in there.tick(0)] == [RepairStatus.RESET]
    assert there.health.level is Level.OK


def test_a_method_that_raises_is_replaced_by_the_rule_guard(bench, monkeypatch):
    there = bench(method="rule")
    there.start()

    def fail(*_):
        raise RuntimeError("out of tune")

    monkeypatch.setattr(RuleRepair, "propose", fail)
    (calm,) = there.tick(2)
    (close,) = there.tick(3, objects=[(7, 62.0, 0.0, 0.0, 4.0)])
    assert calm.state == close.state == RepairStatus.MODEL_FAULT
    assert "out of tune" in calm.reason
    assert calm.final_action == 0.2
    assert close.final_action < -0.5
    assert there.health.level is Level.ERROR
    monkeypatch.undo()
    assert [state.state for state in there.tick(4)] == [RepairStatus.PASS]


def test_a_method_that_takes_too_long_is_replaced_by_the_rule_guard(bench, monkeypatch):
    there = bench(method="rule", time_budget=0.05)
    there.start()
    propose = RuleRepair.propose

    def dawdle(*args):
        time.sleep(0.06)
        return propose(*args)

    monkeypatch.setattr(RuleRepair, "propose", dawdle)
    (state,) = there.tick(2)
    assert state.state == RepairStatus.MODEL_FAULT
    assert "ms of 50.0 ms" in state.reason


@pytest.mark.parametrize(
    ("what", "level"),
    [
        ({"command": Command(7.0, 0.0)}, Level.WARN),
        ({"objects": [(7, 90.0, 0.0, math.nan, 4.0)]}, Level.WARN),
        ({"objects": "unequal"}, Level.ERROR),
    ],
)
def test_what_is_wrong_with_a_tick_is_in_diagnostics_at_once(bench, monkeypatch, what, level):
    there, said = bench(), []
    there.start()
    monkeypatch.setattr(there.node._diagnostics, "publish", lambda: said.append(there.health.level))
    if what.get("objects") == "unequal":
        what = {"objects": objects_message([(7, 90.0, 0.0, 5.0, 4.0)])}
        what["objects"].speed = np.array([1.0, 2.0])
    there.tick(2, **what)
    there.tick(3, **what)
    assert said == [level]


# -- real time ---------------------------------------------------------------------------------------------------------


def test_in_real_time_a_late_command_is_missed_at_once(bench):
    there = bench(clock="realtime", time_budget=10.0)
    there.start()
    there.tick(2, without=("command",))
    assert there.wait(0.03) == []
    (state,) = there.wait(0.02)
    assert (state.state, state.final_action) == (RepairStatus.STALE_COMMAND, STOP)


@pytest.mark.parametrize("part", ["objects", "ego"])
@pytest.mark.parametrize("lag", [1, 3])
def test_in_real_time_what_comes_after_its_tick_was_answered_is_no_clock_that_ran_backwards(bench, part, lag):
    there = bench(clock="realtime", time_budget=10.0)
    there.start()
    for number in range(2, 12):
        there.tick(number, without=(part,))
        there.wait(0.05)
        if number - lag >= 2:
            there.send(number - lag, part)
    stamps = [messages.stamp_of(state.header) for state in there.states.got]
    assert stamps == sorted({*stamps})
    assert RepairStatus.RESET not in [state.state for state in there.states.got[2:]]


def test_odometry_at_the_end_of_time_ends_nothing(bench):
    there = bench(clock="realtime", time_budget=10.0)
    there.start()
    data = bytearray(
        encode(messages.ego_message_of(EgoState.from_yaw(0, 0, 0, 1, 0, 4.7, 1.85), messages.header_of(1.0)))
    )
    data[4:12] = b"\xff\xff\xff\x7f\xff\xff\xff\xff"
    there.node._add("ego", bytes(data))
    assert all(state.final_action == STOP for state in there.wait(0.5))
    assert len(there.states.got) > 2


def drive(bench, rate, ticks, *, without=(), first=2):
    """Ticks that come at a rate, in wall time; the states said, each with the tick that was the newest at the moment."""
    said, steps = [], 5
    for number in range(first, first + ticks):
        said += [(number, state) for state in bench.tick(number, without=without)]
        for _ in range(steps):
            bench.clock.now += 0.05 / rate / steps
            before = len(bench.states.got)
            bench.node._watch()
            said += [(number, state) for state in bench.states.got[before:]]
    return said


RATES = (0.5, 1.0, 1.3, 2.0, 5.0, 10.0)


@pytest.mark.parametrize("rate", RATES)
@pytest.mark.parametrize("missing", [("command",), ("command", "trajectory")])
def test_at_every_rate_a_policy_that_falls_silent_is_a_controlled_stop_within_three_ticks(bench, rate, missing):
    there = bench(clock="realtime", rate=rate, time_budget=10.0)
    there.start()
    said = drive(there, rate, 20, without=missing)
    newest, state = said[0]
    assert newest - 2 <= 2  # tick 2 is the oldest that nobody answered
    assert {(state.state, state.final_action) for _, state in said} == {(int(RepairStatus.STALE_COMMAND), STOP)}
    assert "command" in state.reason
    told = [newest for newest, _ in said]
    assert max(after - before for before, after in itertools.pairwise(told)) <= 1  # it goes on saying so
    assert there.health.level is Level.ERROR
    (state,) = there.tick(30)  # a second without decisions is a jump to the method
    assert (state.state, state.final_action) == (RepairStatus.RESET, 0.2)
    assert consistent(there)


@pytest.mark.parametrize("rate", RATES)
def test_at_every_rate_ticks_in_time_are_driven_and_what_lies_between_them_is_no_silence(bench, rate):
    there = bench(clock="realtime", rate=rate, time_budget=10.0)
    there.start()
    assert [state.state for _, state in drive(there, rate, 20)] == [RepairStatus.PASS] * 20
    (first, *_) = drive(there, rate, 6, without=PARTS, first=22)  # and then nothing comes at all
    assert first[0] - 22 <= 2
    assert first[1].state == RepairStatus.STALE_OBJECTS


def test_in_real_time_a_first_tick_that_is_held_waits_for_the_policy_however_long(bench):
    """An answer in its place would let the vehicle go, and brake it from there on."""
    there = bench(clock="realtime", time_budget=10.0)
    there.route()
    for _ in range(20):
        there.tick(0, without=("command", "trajectory"))
        assert there.wait(0.25) == []
    assert "for want of command, trajectory" in there.health.message
    assert [state.state for state in there.tick(0)] == [RepairStatus.RESET]
    assert there.commands.got[-1].throttle == 0.2


@pytest.mark.parametrize("without", [("command", "trajectory"), ("ego",), ("objects",)])
def test_in_real_time_who_is_not_there_yet_while_time_passes_is_a_start_not_an_emergency(bench, without):
    there = bench(clock="realtime", time_budget=10.0)
    there.route()
    there.tick(7, without=without)  # as a node sees it that was restarted
    there.wait(0.05)
    there.tick(8, without=without)
    there.wait(0.05)
    assert there.states.got
    assert {(state.state, state.final_action) for state in there.states.got} == {(int(RepairStatus.STARTING), STOP)}


def test_in_real_time_silence_never_means_go(bench):
    there = bench(clock="realtime", time_budget=10.0)
    there.start()
    states = there.wait(1.0)
    assert 14 <= len(states) <= 20
    assert {(state.state, state.final_action) for state in states} == {(int(RepairStatus.STALE_OBJECTS), STOP)}
    assert "nothing has arrived" in states[-1].reason
    assert there.health.level is Level.ERROR
    assert [state.state for state in there.tick(2)] == [RepairStatus.PASS]
    assert there.health.level is Level.OK


def test_in_real_time_the_silence_after_the_end_is_no_fault_and_is_not_counted(bench):
    there = bench(clock="realtime", time_budget=10.0)
    there.start()
    there.node._on_event(b"no event")
    there.node._on_event(encode(messages.event_message_of(Event(0.1, EventKind.CHANGE_LANE, ""))))
    before = there.wait(0.2)
    assert {state.state for state in before} == {int(RepairStatus.STALE_OBJECTS)}
    there.node._on_event(encode(messages.event_message_of(Event(0.1, EventKind.GOAL, ""))))
    assert there.wait(1.0) == []
    there.start()
    assert there.wait(0.2)  # another episode


def test_in_real_time_old_commands_that_keep_coming_are_silence_too(bench):
    there = bench(clock="realtime", time_budget=10.0)
    there.start()
    states = []
    for _ in range(50):
        there.send(0, "command", "trajectory")
        states += there.wait(0.02)
    assert len(states) >= 14
    assert {state.state for state in states} == {int(RepairStatus.STALE_OBJECTS)}


def test_in_lockstep_the_simulator_sets_the_pace_and_silence_is_no_fault(bench):
    there = bench()
    there.start()
    assert there.wait(10.0) == []


def test_before_the_first_tick_in_real_time_no_stop_is_claimed_and_who_is_missing_is_named(bench):
    there = bench(clock="realtime", time_budget=10.0, autostart=False)
    there.node.trigger_configure()
    there.node.trigger_activate()
    there.route()
    assert there.wait(1.0) == []
    wanted = "waiting for the first complete tick, for want of ego, objects, command, trajectory"
    assert (there.health.level, there.health.message) == (Level.OK, wanted)
    for _ in range(20):  # the simulator holds it
        there.tick(0, without=("command", "trajectory"))
        assert there.wait(0.25) == []
    wanted = "waiting for the first complete tick, for want of command, trajectory"
    assert (there.health.level, there.health.message) == (Level.OK, wanted)


def test_in_real_time_a_second_episode_begins_like_the_first_whatever_the_last_one_ended_with(bench):
    there = bench(clock="realtime", time_budget=10.0)
    there.start(40)
    assert there.wait(0.2)  # a stop, for want of everything
    there.route()
    answers = there.node._tally.values()["answers"]
    assert there.wait(1.0) == []
    assert there.node._tally.values()["answers"] == answers
    assert there.health.message.startswith("waiting for the first complete tick")
    there.send(0, "objects")  # before the odometry that tells how late it is
    assert there.wait(0.5) == []
    assert [state.state for state in there.tick(0)] == [RepairStatus.RESET]


# -- a policy without plans --------------------------------------------------------------------------------------------


def test_where_nobody_publishes_a_trajectory_and_none_is_required_a_tick_does_without_and_says_so(bench):
    there = bench(trajectory="optional")
    there.wait(0.01)
    there.route()
    for number in range(3):
        (state,) = there.tick(number, without=("trajectory",))
        assert state.reason.startswith("no planned trajectory: ")
    assert state.state == RepairStatus.PASS
    (state,) = there.tick(3, without=("trajectory",), objects=[(7, 62.0, 0.0, 0.0, 4.0)])
    assert (state.state, list(state.trigger_id)) == (RepairStatus.REPAIRED, [7])
    assert "object 7" in state.reason
    assert there.tick(4, without=("command", "trajectory")) == []
    (state,) = there.wait(2.1)
    assert (state.state, "no command within" in state.reason) == (RepairStatus.STALE_COMMAND, True)


def test_a_trajectory_that_somebody_publishes_is_waited_for_again(bench):
    there = bench(trajectory="optional")
    publisher = there.node.create_publisher(msg.Trajectory, topics.POLICY_TRAJECTORY, qos.STREAM)
    assert publisher.topic_name == "/policy/trajectory"
    deadline = time.monotonic() + 20.0
    while not there.node.count_publishers(topics.POLICY_TRAJECTORY) and time.monotonic() < deadline:
        time.sleep(0.02)
    there.wait(0.3)
    there.route()
    assert there.tick(0, without=("trajectory",)) == []
    (state,) = there.tick(0)
    assert "trajectory" not in state.reason


def test_a_command_of_no_tick_is_not_paired_and_is_named_until_one_fits(bench):
    there = bench()
    there.route()
    there.send(0, "ego", "objects")
    there.send(10**6, "command", "trajectory")
    assert there.states.got == []
    assert "stamped 50000.00 s and belong to no tick, which is at 0.00 s" in there.health.message
    (state,) = there.tick(0, without=("ego", "objects"))
    assert state.state == RepairStatus.RESET
    assert there.health.message == "repairing"


def test_what_the_first_tick_lacks_is_named(bench):
    there = bench()
    there.route()
    there.send(0, "ego", "objects", "trajectory")
    assert there.health.message == "waiting for the first complete tick, for want of command"


# -- over DDS ----------------------------------------------------------------------------------------------------------


def test_over_dds_it_answers_while_active_and_sends_nothing_while_inactive(domain, tmp_path, monkeypatch):
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    rclpy.init(args=["test"], domain_id=domain)
    executor = EventsExecutor()
    node, other = module.RepairNode(), Node("pretended")
    for one in (node, other):
        executor.add_node(one)
    got = []
    try:
        other.create_subscription(msg.Command, topics.REPAIR_COMMAND, got.append, qos.COMMAND)
        to = {
            "ego": other.create_publisher(Odometry, topics.EGO, qos.STREAM),
            "objects": other.create_publisher(msg.ObjectList, topics.OBJECTS, qos.STREAM),
            "command": other.create_publisher(msg.Command, topics.POLICY_COMMAND, qos.COMMAND),
            "trajectory": other.create_publisher(msg.Trajectory, topics.POLICY_TRAJECTORY, qos.STREAM),
        }
        there = Bench.__new__(Bench)
        there.node = node
        there.route()

        def until(done, limit=10.0):
            end = time.monotonic() + limit
            while not done() and time.monotonic() < end:
                executor.spin_once(timeout_sec=0.02)
            return done()

        assert until(lambda: all(publisher.get_subscription_count() for publisher in to.values()))
        assert until(lambda: node.count_subscribers(topics.REPAIR_COMMAND))

        def tick(number):
            header = messages.header_of(0.05 * number)
            ego = EgoState.from_yaw(50.0, 0.0, 0.0, 5.0, 0.0, 4.7, 1.85)
            to["ego"].publish(encode(messages.ego_message_of(ego, header)))
            to["objects"].publish(encode(messages.OBJECTS(header=header)))
            to["trajectory"].publish(encode(messages.trajectory_message_of(Trajectory.empty(), header)))
            to["command"].publish(encode(messages.command_message_of(Command(0.25, 0.0), header)))

        tick(0)
        assert until(lambda: got)
        assert (got[0].throttle, got[0].brake) == (0.25, 0.0)
        node.trigger_deactivate()
        tick(1)
        assert not until(lambda: len(got) > 1, limit=0.5)
        node.trigger_activate()
        tick(2)
        assert until(lambda: len(got) > 1)
        assert messages.stamp_of(got[-1].header) == 100_000_000
    finally:
        put_away(executor, node, other)
