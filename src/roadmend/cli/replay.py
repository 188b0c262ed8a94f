"""``roadmend replay``: play a bag into the graph."""

import json
import os
from pathlib import Path
from typing import Any

import click

from roadmend.nodes.replay import main


@click.command(context_settings={"ignore_unknown_options": True})
@click.argument("bag", type=click.Path(path_type=Path))
@click.option(
    "--rate", default=1.0, show_default=True, type=click.FloatRange(1e-3, 1e3), help="Recorded seconds per second."
)
@click.option(
    "--start", default=0.0, show_default=True, type=click.FloatRange(0.0), help="Begin this many seconds into the bag."
)
@click.option("--loop", is_flag=True, help="Begin again at the end.")
@click.option(
    "--topic", "topics", multiple=True, help="Play this topic, and the clock; may be repeated.  [default: all]"
)
@click.option("--exclude", multiple=True, help="Do not play this topic; may be repeated.")
@click.option("--paused", is_flag=True, help="Wait for the service replay_node/resume or replay_node/step.")
@click.option(
    "--lockstep", is_flag=True, help="Play no repairs: each tick waits for those of a live repair_node, at any rate."
)
@click.option("--wait-for", multiple=True, help="Begin when this node listens; may be repeated.")
@click.option("--wait-for-listeners", is_flag=True, help="Begin when every topic has a listener, such as a recorder.")
@click.argument("ros_arguments", nargs=-1, type=click.UNPROCESSED, metavar="[--ros-args ...]")
def replay(
    bag: Path,
    rate: float,
    start: float,
    topics: tuple[str, ...],
    exclude: tuple[str, ...],
    wait_for: tuple[str, ...],
    ros_arguments: tuple[str, ...],
    *,
    loop: bool,
    paused: bool,
    lockstep: bool,
    wait_for_listeners: bool,
) -> int:
    """Publish what a bag holds, with the QoS it was recorded with, and the clock.

    Remap topics with --ros-args -r OLD:=NEW, put all but the clock into a namespace with -r __ns:=/NAME.
    """
    if ros_arguments and ros_arguments[0] != "--ros-args":
        raise click.UsageError(f"unexpected argument {ros_arguments[0]!r}")
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    parameters: dict[str, Any] = {
        "bag": str(bag),
        "rate": rate,
        "start_offset": start,
        "loop": loop,
        "topics": topics or [""],
        "exclude": exclude or [""],
        "start_paused": paused,
        "clock": "lockstep" if lockstep else "realtime",
        "wait_for": wait_for or [""],
        "wait_for_listeners": wait_for_listeners,
    }
    given = [word for name, value in parameters.items() for word in ("-p", f"{name}:={json.dumps(value)}")]
    return main(["replay_node", "--ros-args", *given, *ros_arguments[1:]])
