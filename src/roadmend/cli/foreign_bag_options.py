"""Options that say where a bag of another stack has what roadmend looks at, and what it does not tell of the vehicle."""

from dataclasses import dataclass, fields
from typing import Annotated, Any

import click

from roadmend.cli.options import Number
from roadmend.core.parameters import bound_of
from roadmend.recording.foreign_commands import COMMAND_FORMS, Pedals
from roadmend.recording.foreign_objects import OBJECT_READERS, EgoOutline
from roadmend.recording.foreign_parameters import PATIENCE_MAX_S, PATIENCE_S, ForeignParameters
from roadmend.recording.foreign_shadow import ForeignTopics

_OF = "Of another stack's bag"


def _topic(option: str, meaning: str) -> Any:
    return click.option(f"--{option}", default="", metavar="TOPIC", help=f"{_OF}: {meaning}.")


def _parameter(name: str, meaning: str) -> Any:
    """The option for a parameter that repair_node has too, with its default and range."""
    field = ForeignParameters.model_fields[name]
    kind = Number(bound_of(field, "ge"), bound_of(field, "le"))
    text = f"{_OF}: {meaning}."
    return click.option(f"--{name.replace('_', '-')}", default=field.default, show_default=True, type=kind, help=text)


@dataclass(frozen=True)
class ForeignSceneOptions:
    """Where the scene is, and the size of the ego."""

    ego: Annotated[str, _topic("ego", "odometry of the ego, nav_msgs/Odometry")]
    objects: Annotated[str, _topic("objects", f"the objects, {' or '.join(OBJECT_READERS)}")]
    ego_length: Annotated[float, _parameter("ego_length", "length of the ego [m]")]
    ego_width: Annotated[float, _parameter("ego_width", "width of the ego [m]")]
    ego_centre: Annotated[float, _parameter("ego_centre", "its centre ahead of the odometry's frame [m]")]

    @property
    def vehicle(self) -> EgoOutline:
        """What odometry does not tell of the ego."""
        return EgoOutline(self.ego_length, self.ego_width, self.ego_centre)


@dataclass(frozen=True)
class ForeignBagOptions(ForeignSceneOptions):
    """And where the commands are and what they mean, and what else there may be."""

    command: Annotated[str, _topic("command", f"what the policy asked for, {' or '.join(COMMAND_FORMS)}")]
    trajectory: Annotated[str, _topic("trajectory", "planned trajectories, if there are any, roadmend_msgs/Trajectory")]
    route: Annotated[str, _topic("route", "the route, if there is one, roadmend_msgs/Route")]
    full_throttle: Annotated[
        float, _parameter("full_throttle", "acceleration at full throttle, where commands are accelerations [m/s²]")
    ]
    full_brake: Annotated[float, _parameter("full_brake", "deceleration at full brake [m/s²]")]
    input_timeout: Annotated[
        float,
        click.option(
            "--input-timeout",
            default=PATIENCE_S,
            show_default=True,
            type=Number(0.0, PATIENCE_MAX_S, min_open=True),
            help=f"{_OF}: seconds of its time after which an input counts as late.",
        ),
    ]

    @property
    def pedals(self) -> Pedals:
        """What the vehicle makes of its pedals."""
        return Pedals(self.full_throttle, self.full_brake)

    @property
    def topics(self) -> ForeignTopics | None:
        """The topics; None where none is named, as for a bag of roadmend."""
        given = ForeignTopics(self.ego, self.objects, self.command, self.trajectory, self.route)
        return given if any(vars(self)[each.name] for each in fields(given)) else None
