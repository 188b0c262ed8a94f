"""``roadmend replay``: a bag, published as it was recorded."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.options import PATH, Number, options_of
from roadmend.cli.ros_arguments import ROS_ARGUMENTS, ros_arguments
from roadmend.nodes.loopback import reach
from roadmend.nodes.ros_arguments import as_yaml

INTERRUPTED = 130  # exit code


@dataclass(frozen=True)
class ReplayOptions:
    """What to play, and how."""

    bag: Annotated[Path, click.argument("bag", type=PATH)]
    rate: Annotated[
        float,
        click.option(
            "--rate",
            default=1.0,
            show_default=True,
            type=Number(1e-3, 1e3),
            help="Recorded seconds per second.",
        ),
    ]
    start: Annotated[
        float,
        click.option(
            "--start",
            default=0.0,
            show_default=True,
            type=Number(0.0),
            help="Begin this many seconds into the bag.",
        ),
    ]
    loop: Annotated[bool, click.option("--loop", is_flag=True, help="Begin again at the end.")]
    topics: Annotated[
        tuple[str, ...],
        click.option(
            "--topic", "topics", multiple=True, help="Play this topic, and the clock; may be repeated.  [default: all]"
        ),
    ]
    exclude: Annotated[
        tuple[str, ...], click.option("--exclude", multiple=True, help="Do not play this topic; may be repeated.")
    ]
    paused: Annotated[
        bool,
        click.option("--paused", is_flag=True, help="Wait for the service replay_node/resume or replay_node/step."),
    ]
    lockstep: Annotated[
        bool,
        click.option(
            "--lockstep",
            is_flag=True,
            help="Play no repairs: each tick waits for those of a live repair_node, at any rate.",
        ),
    ]
    wait_for: Annotated[
        tuple[str, ...],
        click.option("--wait-for", multiple=True, help="Begin when this node listens; may be repeated."),
    ]
    wait_for_listeners: Annotated[
        bool,
        click.option(
            "--wait-for-listeners", is_flag=True, help="Begin when every topic has a listener, such as a recorder."
        ),
    ]
    ros_arguments: Annotated[tuple[str, ...], ROS_ARGUMENTS]


@click.command(
    context_settings={"ignore_unknown_options": True},
    cls=ExampleCommand,
    examples=[
        "roadmend replay bags/my-run --rate 2 --loop",
        "roadmend replay bags/my-run --topic /ego --topic /objects",
    ],
)
@options_of(ReplayOptions)
def replay(given: ReplayOptions) -> int:
    """Publish what a bag holds, with the QoS it was recorded with, and the clock.

    Remap topics with --ros-args -r OLD:=NEW, put all but the clock into a namespace with -r __ns:=/NAME.
    """
    extra = ros_arguments(given.ros_arguments)
    from roadmend.nodes.replay import main  # noqa: PLC0415 - rclpy is for this command alone

    os.environ.update(reach())
    parameters: dict[str, Any] = {
        "bag": str(given.bag),
        "rate": given.rate,
        "start_offset": given.start,
        "loop": given.loop,
        "topics": given.topics or [""],
        "exclude": given.exclude or [""],
        "start_paused": given.paused,
        "clock": "lockstep" if given.lockstep else "realtime",
        "wait_for": given.wait_for or [""],
        "wait_for_listeners": given.wait_for_listeners,
    }
    words = [word for name, value in parameters.items() for word in ("-p", f"{name}:={as_yaml(value)}")]
    code = main(["replay_node", "--ros-args", *words, *extra], interrupted=INTERRUPTED)
    if code == INTERRUPTED:
        raise click.Abort
    return code
