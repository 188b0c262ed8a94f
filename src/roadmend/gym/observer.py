"""Follows an episode, so that each scene can be told as an observation: in the environment, and in the graph."""

import reprlib
from collections.abc import Callable

import numpy as np

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.gym.observation import Observation, observe
from roadmend.measures.route_progress import RoutePlace, RouteProgress


class DriveObserver:
    """Fed with the scenes of an episode in their order.

    Attributes:
        place: where on its route the ego is.
        left: way to the goal [m].
        limit: speed limit where the ego is [m/s].
    """

    def __init__(self, most: int) -> None:
        self._most = most

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``."""
        self._route = route
        self._progress = RouteProgress(route)
        self._speed: float | None = None

    def see(self, scene: Scene) -> Observation:
        """Take in the next scene; see ``gym.observation`` for what comes out."""
        before = scene.ego.speed if self._speed is None else self._speed
        self._speed = scene.ego.speed
        self.place: RoutePlace = self._progress.observe(scene.ego)
        self.left = self._progress.left(self.place)
        self.limit = self._route.stages[self.place.stage].limit_at(self.place.position)
        return observe(scene, self._route, self.place, self.left, before, self._most)


class LearnedPolicy:
    """What was learned in ``roadmend/Drive-v0``, as a policy that drives everywhere else; it plans no trajectory.

    Args:
        act: gives the action for an observation, such as ``lambda seen: model.predict(seen, deterministic=True)[0]``.
        objects: participants that an observation has room for, as it was learned with.
    """

    name = "learned"

    def __init__(self, act: Callable[[Observation], np.ndarray], objects: int = 16) -> None:
        self._act = act
        self._observer = DriveObserver(objects)

    def reset(self, route: Route) -> None:
        """Begin an episode."""
        self._observer.reset(route)

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick.

        Raises:
            InputError: what was learned answers with no action.
        """
        return Decision(command_of(self._act(self._observer.see(scene))), Trajectory.empty())


def command_of(action: np.ndarray, shape: tuple[int, ...] | None = None) -> Command:
    """What an action tells the vehicle.

    Args:
        action: throttle - brake, -1 to 1; and perhaps a second number, above 0 where the route's next lane change shall
            begin. Without it, it begins as soon as it may.
        shape: that it must have; either of the two if None.

    Raises:
        InputError: it is no such action.
    """
    try:
        given = np.asarray(action)
        numbers = given.astype(np.float64) if given.dtype.kind in "biuf" else np.empty(())
    except ValueError:  # rows of different lengths
        numbers = np.empty(())
    if numbers.shape not in ({(1,), (2,)} if shape is None else {shape}) or not np.all(np.abs(numbers) <= 1.0):
        shown = np.array2string(numbers, precision=3, threshold=4) if numbers.ndim else reprlib.repr(action)
        what = f"{shown} is no action"
        counts: dict[tuple[int, ...] | None, str] = {
            None: "one number, throttle - brake, or two,",
            (1,): "one number, throttle - brake,",
        }
        count = counts.get(shape, "two numbers, throttle - brake and lane change,")
        raise InputError("roadmend/Drive-v0", what, f"give {count} each in -1 .. 1")
    return Command.from_action(float(numbers[0]), change_lane=len(numbers) == 1 or float(numbers[1]) > 0.0)
