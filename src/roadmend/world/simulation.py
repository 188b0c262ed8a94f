"""One episode in SUMO: the ego on its own dynamics, everybody else on SUMO's."""

import contextlib
import math
import os
import random
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Self

import libsumo
import numpy as np
from numpy.typing import NDArray

from roadmend.core.command import Command
from roadmend.core.errors import InputError, SimulationError
from roadmend.core.outcome import Event
from roadmend.core.route import Route
from roadmend.core.scene import EgoState, ObjectKind, Scene, Signal
from roadmend.core.tick import INTERVAL, INTERVAL_NS, Tick
from roadmend.world import events as happened
from roadmend.world.blame import find_blame
from roadmend.world.courtesy import Courtesy
from roadmend.world.ego import STANDING, LongitudinalDynamics, RouteFollower, VehicleParameters
from roadmend.world.ego_in_sumo import EgoInSumo
from roadmend.world.impacts import Impacts
from roadmend.world.joining import join_traffic
from roadmend.world.levels import roads_on_other_levels
from roadmend.world.manoeuvres import ManoeuvreScript
from roadmend.world.network import network_file
from roadmend.world.participants import Observation, Participants, Pose, all_vehicles
from roadmend.world.road_network import RoadNetwork, read_network
from roadmend.world.route_builder import BuiltRoute, build_route
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_actors import Pedestrian
from roadmend.world.scenario_networks import SumoConfiguration
from roadmend.world.stand_off import StandOff
from roadmend.world.traffic_file import EGO, traffic_xml
from roadmend.world.user_configuration import private_copy
from roadmend.world.variation import Spread, deviation, vary_traffic

LATERAL_RESOLUTION = 0.8  # [m] SUMO's sublane model: partial overlap, bicycles beside cars, gradual lane changes

_SIGNALS = {
    "G": Signal.GREEN,
    "g": Signal.GREEN,
    "y": Signal.YELLOW,
    "Y": Signal.YELLOW,
    "r": Signal.RED,
    "R": Signal.RED,
    "u": Signal.RED,
    "s": Signal.GREEN,
    "o": Signal.OFF,
    "O": Signal.OFF,
}


_NO_SIGNALS = np.empty(0, dtype=np.uint8)


class Simulation:
    """Runs one scenario. libsumo holds one simulation a process, so only one of these may be open at a time."""

    def __init__(self, scenario: Scenario, *, report_collisions: bool = False) -> None:
        """Load a scenario and place the ego.

        Args:
            scenario: what to run.
            report_collisions: let SUMO look for collisions too (tests compare the two).

        Raises:
            InputError: the scenario names something that does not exist.
            SimulationError: SUMO refuses to start, or another one is open.
        """
        if libsumo.isLoaded():  # it would be taken away from who drives in it, without a word
            raise SimulationError(
                "another episode is under way in this process, and SUMO holds one a process; "
                "end that one first, or drive in a process of its own"
            )
        self.scenario = scenario
        self._is_users = isinstance(scenario.network, SumoConfiguration)
        self.network: RoadNetwork = read_network(network_file(scenario.network))
        # A route that is given is checked before SUMO starts; one from the traffic is known only after the warm-up.
        built = build_route(self.network, scenario) if scenario.ego.route or not self._is_users else None
        self._files = tempfile.TemporaryDirectory(prefix="roadmend-")
        try:
            _start(self._arguments(report_collisions=report_collisions), scenario)
            if isinstance(scenario.network, SumoConfiguration):
                with _refused(scenario.network.path):
                    self._warm_up(scenario.network)
                    self.scenario = scenario = join_traffic(scenario, self.network)
                built = build_route(self.network, scenario)
            assert built is not None
            self._built: BuiltRoute = built
            with _refused(getattr(scenario.network, "path", scenario.name)):
                self._body = EgoInSumo(scenario, INTERVAL)
        except BaseException:
            self.close()
            raise
        environment = scenario.environment
        limited = not self._is_users or environment.limits_sight
        with_persons = self._is_users or any(isinstance(actor, Pedestrian) for actor in scenario.actors)
        self._impacts = Impacts(scenario.obstacles, is_users=self._is_users)
        self._participants = Participants(
            EGO,
            INTERVAL,
            environment.effective_range if limited else math.inf,
            with_persons=with_persons,
            elsewhere=roads_on_other_levels(self.network, scenario.ego.route, built.route),
            fixed=self._impacts.standing,
        )
        self._courtesy = Courtesy()
        self._stand_off = StandOff(INTERVAL, self._impacts.standing)
        self._script = ManoeuvreScript(scenario, self._courtesy)
        self._dynamics = LongitudinalDynamics(VehicleParameters(), environment.effective_friction, scenario.ego.speed)
        self._follower = RouteFollower(built.route, built.start_position)
        self._tick = 0
        self._last_yaw = self._follower.yaw
        self._final: Event | None = None
        self._seen: Observation | None = None

    @property
    def route(self) -> Route:
        """The ego's route."""
        return self._built.route

    @property
    def seen(self) -> Observation | None:
        """Everybody around the ego at the last tick, by name; None before the first one."""
        return self._seen

    def everyone(self) -> dict[str, Pose]:
        """All other vehicles on the map at the last tick, near or far, and the obstacles that stand there, by name."""
        return {**all_vehicles(EGO), **self._impacts.standing}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the simulation; harmless when it has ended before."""
        with contextlib.suppress(libsumo.TraCIException, libsumo.FatalTraCIError):
            libsumo.close()
        self._files.cleanup()

    def first(self) -> Tick:
        """The scene before anything has moved."""
        self._step_sumo(0.0)
        return self._observe((happened.started(self.scenario.name, self.route.length),))

    def step(self, command: Command) -> Tick:
        """Drive the ego on ``command`` for one interval and let everybody else move.

        Raises:
            SimulationError: the episode is over, or SUMO failed.
        """
        if self._final is not None:
            raise SimulationError("the episode is over; open a new Simulation")
        follower, dynamics = self._follower, self._dynamics
        events: tuple[Event, ...] = ()
        if command.change_lane and follower.begin_change(dynamics.speed):
            events = (happened.change_of_lane(self._tick * INTERVAL, follower.stage + 1),)
        distance = dynamics.step(command, INTERVAL, follower.curvature)
        follower.advance(distance)
        self._tick += 1
        pose = (follower.x, follower.y, follower.yaw)
        self._script.step(self._tick * INTERVAL, pose, self._seen)
        self._impacts.step(self._script.steered)
        self._step_sumo(distance)
        return self._observe(events)

    def vary(self, seed: int, spread: Spread) -> None:
        """From now on the world differs, by chance, as another day's might: the others, and how the ego obeys.

        Raises:
            SimulationError: SUMO failed.
        """
        numbers = random.Random(f"{self.scenario.seed}:{self._tick}:{seed}")
        try:
            vary_traffic(self.scenario, self._tick * INTERVAL, numbers, spread)
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            raise SimulationError(f"SUMO failed at {self._tick * INTERVAL:.2f} s: {error}") from None
        engine, brake = (1.0 + deviation(numbers, spread.actuation, spread) for _ in range(2))
        self._dynamics.scale(engine, brake)

    def _step_sumo(self, distance: float) -> None:
        try:
            self._body.follow(self._follower, distance)
            libsumo.simulation.step()
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            reason = " ".join(self._reason(error).split())
            raise SimulationError(f"SUMO failed at {self._tick * INTERVAL:.2f} s: {reason}") from None

    def _reason(self, error: Exception) -> str:
        follower = self._follower
        left = follower.route.stages[follower.stage].length - follower.position - 0.5 * self.scenario.ego.length
        if left <= 0.0 and follower.stage == len(follower.route.stages) - 1:
            return (
                "the ego's front came to the end of the road before its centre came to ego.goal; choose a smaller one"
            )
        return str(error)

    def _observe(self, events: tuple[Event, ...]) -> Tick:
        follower, scenario = self._follower, self.scenario
        time = self._tick * INTERVAL_NS * 1e-9  # the float that a message's stamp gives back
        yaw_rate = math.remainder(follower.yaw - self._last_yaw, 2.0 * math.pi) / INTERVAL
        self._last_yaw = follower.yaw
        ego = EgoState.from_yaw(
            follower.x,
            follower.y,
            follower.yaw,
            self._dynamics.speed,
            yaw_rate,
            scenario.ego.length,
            scenario.ego.width,
        )
        seen = self._seen = self._participants.observe(ego)
        heedless = {*self._script.heedless, *self._impacts.standing}
        self._courtesy.step(ego, seen.names, seen.around, heedless, self._script.held)
        names = self._hit(seen, ego.speed) if seen.nearest <= 0.0 else ()
        if names:
            blame = find_blame(ego, seen.around, seen.names.index(names[0]), changing=follower.changing)
            self._final = happened.collision(time, [self._who(name) for name in names], blame, ego.speed)
        elif follower.at_goal:
            self._final = happened.goal(time)
        elif follower.off_route:
            self._final = happened.off_route(time)
        elif time >= scenario.time_limit - 1e-9:
            self._final = happened.timeout(time, scenario.time_limit)
        else:
            events = (*events, *self._clear(seen, ego, time))
        if self._final is not None:
            events = (*events, self._final)
        return Tick(self._tick, Scene(time, ego, seen.objects, self._signals()), seen.nearest, events, self._final)

    def _clear(self, seen: Observation, ego: EgoState, time: float) -> list[Event]:
        """End a stand-off that nobody in it would end."""
        follower = self._follower
        stage = follower.route.stages[follower.stage]
        names = self._stand_off.step(
            ego, lambda ahead: stage.pose(follower.position + ahead), seen.names, seen.around, self._courtesy.waiting
        )
        return [happened.cleared(time, *self._who(name)) for name in names]

    def _who(self, name: str) -> tuple[int, str, ObjectKind]:
        """The object id, name and kind of a participant."""
        return self._participants.number_of(name), name, self._participants.kind_of(name)

    def _hit(self, seen: Observation, speed: float) -> tuple[str, ...]:
        """Those whose outline meets the ego's.

        SUMO's pedestrians walk through a car that stands on their way; that is a contact only while the ego moves.
        """
        return tuple(
            name
            for name, gap in zip(seen.names, seen.distances, strict=True)
            if gap <= 0.0 and (speed > STANDING or self._participants.kind_of(name) != ObjectKind.PEDESTRIAN)
        )

    def _signals(self) -> NDArray[np.uint8]:
        if not self._built.signals:
            return _NO_SIGNALS
        return np.array(
            [
                _SIGNALS.get(
                    libsumo.trafficlight.getRedYellowGreenState(link.traffic_light)[link.link_index], Signal.OFF
                )
                for link in self._built.signals
            ],
            dtype=np.uint8,
        )

    def _arguments(self, *, report_collisions: bool) -> list[str]:
        scenario = self.scenario
        arguments = [
            "--step-length",
            f"{INTERVAL:g}",
            "--seed",
            str(scenario.seed),
            "--no-step-log",
            "true",
            "--no-warnings",
            "true",
            "--duration-log.disable",
            "true",
            "--time-to-teleport",
            "-1",
            "--collision.action",
            "warn" if report_collisions else "none",
        ]
        if isinstance(scenario.network, SumoConfiguration):
            return [*private_copy(Path(scenario.network.path), Path(self._files.name)), *arguments]
        routes = Path(self._files.name) / "traffic.rou.xml"
        routes.write_text(traffic_xml(scenario, self.network), encoding="utf-8")
        if report_collisions:
            arguments += ["--collision.check-junctions", "true", "--collision.mingap-factor", "0"]
        return [
            "-n",
            str(self.network.path),
            "-r",
            str(routes),
            # Only overlap forbids an entry: the scenario says where everyone is, and so does who varies it.
            "--insertion-checks",
            "collision",
            "--lateral-resolution",
            f"{LATERAL_RESOLUTION:g}",
            *arguments,
        ]

    def _warm_up(self, configuration: SumoConfiguration) -> None:
        begin = libsumo.simulation.getTime()
        libsumo.simulation.step(begin + configuration.warm_up)


@contextlib.contextmanager
def _refused(where: str) -> Iterator[None]:
    """Where SUMO fails before the ego has moved, the configuration is at fault.

    Raises:
        InputError: it failed.
    """
    failure: str | None = None
    with _captured_stderr():  # SUMO says there once more what the exception says
        try:
            yield
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            failure = " ".join(str(error).split())
    if failure is not None:
        raise InputError(where, f"SUMO fails in it: {failure.rstrip('.')}", "mend what it names")


def _start(arguments: list[str], scenario: Scenario) -> None:
    with _captured_stderr() as printed:
        try:
            libsumo.start(["sumo", *arguments])
        except (libsumo.TraCIException, libsumo.FatalTraCIError) as error:
            failure: str | None = str(error)
        else:
            failure = None
    if failure is not None:
        said = [line.removeprefix("Error: ") for line in printed if line.startswith("Error: ")]
        reason = (said[0] if said else failure).strip().replace("\n", " ")
        where = getattr(scenario.network, "path", scenario.name)
        raise InputError(str(where), f"SUMO refuses it: {reason}", "mend what it names")


@contextlib.contextmanager
def _captured_stderr() -> Iterator[list[str]]:
    """Collect what native code prints to stderr, so that an error is one line and not two."""
    lines: list[str] = []
    sys.stderr.flush()
    saved = os.dup(2)
    with tempfile.TemporaryFile() as sink:
        os.dup2(sink.fileno(), 2)
        try:
            yield lines
        finally:
            os.dup2(saved, 2)
            os.close(saved)
            sink.seek(0)
            lines += sink.read().decode(errors="replace").splitlines()
