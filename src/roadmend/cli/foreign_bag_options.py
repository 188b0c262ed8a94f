"""Options that say where a bag of another stack has what roadmend looks at, and what it does not tell of the ego."""

from dataclasses import dataclass, fields
from typing import Annotated, Any

import click

from roadmend.cli.options import Number
from roadmend.recording.foreign_commands import COMMAND_FORMS
from roadmend.recording.foreign_objects import OBJECT_READERS, EgoOutline
from roadmend.recording.foreign_shadow import ForeignTopics
from roadmend.recording.messages import EGO_SIZE


def _topic(option: str, meaning: str) -> Any:
    return click.option(f"--{option}", default="", metavar="TOPIC", help=f"Of another stack's bag: {meaning}.")


def _metres(option: str, default: float, low: float, meaning: str) -> Any:
    kind = Number(low, 60.0)
    text = f"Of another stack's bag: {meaning} [m]."
    return click.option(f"--{option}", default=default, show_default=True, type=kind, help=text)


@dataclass(frozen=True)
class ForeignSceneOptions:
    """Where the scene is, and the size of the ego."""

    ego: Annotated[str, _topic("ego", "odometry of the ego, nav_msgs/Odometry")]
    objects: Annotated[str, _topic("objects", f"the objects, {' or '.join(OBJECT_READERS)}")]
    ego_length: Annotated[float, _metres("ego-length", EGO_SIZE[0], 0.1, "length of the ego")]
    ego_width: Annotated[float, _metres("ego-width", EGO_SIZE[1], 0.1, "width of the ego")]
    ego_centre: Annotated[float, _metres("ego-centre", 0.0, -60.0, "its centre ahead of the odometry's frame")]

    @property
    def vehicle(self) -> EgoOutline:
        """What odometry does not tell of the ego."""
        return EgoOutline(self.ego_length, self.ego_width, self.ego_centre)


@dataclass(frozen=True)
class ForeignBagOptions(ForeignSceneOptions):
    """And where the commands are, and what else there may be."""

    command: Annotated[str, _topic("command", f"what the policy asked for, {' or '.join(COMMAND_FORMS)}")]
    trajectory: Annotated[str, _topic("trajectory", "planned trajectories, if there are any, roadmend_msgs/Trajectory")]
    route: Annotated[str, _topic("route", "the route, if there is one, roadmend_msgs/Route")]

    @property
    def topics(self) -> ForeignTopics | None:
        """The topics; None where none is named, as for a bag of roadmend."""
        given = ForeignTopics(self.ego, self.objects, self.command, self.trajectory, self.route)
        return given if any(vars(self)[each.name] for each in fields(given)) else None
