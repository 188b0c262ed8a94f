"""``roadmend repair``: repair and recorder alone, beside nodes of another stack."""

import json
import sys
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.driver_options import METHOD_NAME, REPAIR_SEED
from roadmend.cli.options import BAGS, JSON, RECORD, options_of
from roadmend.cli.output import show_rows
from roadmend.cli.ros_arguments import ROS_ARGUMENTS, ros_arguments
from roadmend.core.errors import RoadmendError
from roadmend.nodes.repair_launcher import RepairGraphOptions, RepairRun, run_repair
from roadmend.nodes.run_result import gap_of
from roadmend.recording import topics
from roadmend.recording.foreign_commands import COMMAND_FORMS
from roadmend.recording.foreign_objects import OBJECT_READERS

OBJECT_TYPES, COMMAND_TYPES = [*OBJECT_READERS], [*COMMAND_FORMS]


@dataclass(frozen=True)
class StackOptions:
    """Where the inputs are, and what repairs."""

    method: Annotated[str, click.option("--repair", "method", default="rss", show_default=True, type=METHOD_NAME)]
    seed: Annotated[int, REPAIR_SEED]
    ego: Annotated[
        str, click.option("--ego", default="", metavar="TOPIC", help="The ego's nav_msgs/Odometry.  [default: ego]")
    ]
    objects: Annotated[
        str, click.option("--objects", default="", metavar="TOPIC", help="The objects around it.  [default: objects]")
    ]
    command: Annotated[
        str,
        click.option(
            "--command", default="", metavar="TOPIC", help="What your policy asks for.  [default: policy/command]"
        ),
    ]
    repaired: Annotated[
        str,
        click.option(
            "--repaired", default="", metavar="TOPIC", help="What the vehicle shall do.  [default: repair/command]"
        ),
    ]
    objects_type: Annotated[
        str,
        click.option("--objects-type", default=OBJECT_TYPES[0], show_default=True, type=click.Choice(OBJECT_TYPES)),
    ]
    command_type: Annotated[
        str,
        click.option("--command-type", default=COMMAND_TYPES[0], show_default=True, type=click.Choice(COMMAND_TYPES)),
    ]
    out: Annotated[Path, BAGS]
    name: Annotated[str, click.option("--name", default="", help="Name of the bag.  [default: from method and time]")]
    record: Annotated[bool, RECORD]
    record_topics: Annotated[
        str, click.option("--record-topics", default="", metavar="REGEX", help="Record these.  [default: every topic]")
    ]
    sim_time: Annotated[
        bool, click.option("--sim-time", is_flag=True, help="The stack's time comes from /clock, not from the wall.")
    ]
    as_json: Annotated[bool, JSON]
    ros_arguments: Annotated[tuple[str, ...], ROS_ARGUMENTS]


@click.command(
    context_settings={"ignore_unknown_options": True},
    cls=ExampleCommand,
    examples=[
        "roadmend repair --repair rss",
        (
            "roadmend repair --ego /odom --objects /detections --objects-type vision_msgs/msg/Detection3DArray "
            "--command /drive/accel --command-type geometry_msgs/msg/AccelStamped"
        ),
    ],
)
@options_of(StackOptions)
def repair(given: StackOptions) -> None:
    """Repair what your own stack drives: guard, method and recorder alone, until Ctrl-C.

    Each command is answered with the newest odometry and objects; whatever is late or missing is named, and stops the
    vehicle. After --ros-args come parameters of the repair node, -p ego_length:=4.2, or of the recorder,
    -p recorder_node:exclude:=camera, and remappings for both, -r NAME:=/OTHER.
    """
    names = {
        topics.EGO: given.ego,
        topics.OBJECTS: given.objects,
        topics.POLICY_COMMAND: given.command,
        topics.REPAIR_COMMAND: given.repaired,
    }
    remapped = [word for name, target in names.items() if target for word in ("-r", f"{name}:={target}")]
    options = RepairGraphOptions(
        given.method,
        given.seed,
        {"objects_type": given.objects_type, "command_type": given.command_type},
        given.out,
        given.name,
        given.record,
        given.record_topics,
        given.sim_time,
        (*remapped, *ros_arguments(given.ros_arguments)),
    )
    result = run_repair(options, lambda text: print(f"roadmend: {text}", file=sys.stderr))
    _show(result, as_json=given.as_json)
    if result.lost_messages:
        print(f"roadmend: {gap_of(result.bag, result.lost_messages)}", file=sys.stderr)
    for trouble in (result.method_error, result.recording_error, "; ".join(result.faults)):
        if trouble:
            raise RoadmendError(trouble)


def _show(result: RepairRun, *, as_json: bool) -> None:
    if as_json:
        click.echo(json.dumps(asdict(result), indent=2))
        return
    states = ", ".join(f"{name} {count}" for name, count in sorted(result.states.items())) or "-"
    heading = ("answers", "interventions", "states", "restarts", "bag")
    row = (str(result.answers), str(result.interventions), states, str(result.restarts), result.bag or "-")
    show_rows([heading, row])
