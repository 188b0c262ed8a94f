"""The whole graph: ``ros2 launch roadmend graph.launch.py scenario:=s.yaml repair:=adreft``.

Every node of a run, under a namespace and with remappings if they are given. The run ends when the simulator does.
``roadmend run`` does the same without launch, and beyond it restarts a node that dies and ends one that hangs.

``sim:=false`` starts repair and recorder beside nodes of your own, as ``roadmend repair`` does: their odometry, objects
and commands come under any name (``remap``), at any rate.
"""

import time
from pathlib import Path

from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, SetRemap

from launch import LaunchContext, LaunchDescription

YES = ("true", "1", "yes")
NO = ("false", "0", "no")

# name -> default and meaning; those of `roadmend run` have its names
ARGUMENTS = {
    "scenario": ("", "scenario file to drive"),
    "policy": (
        "",
        "driving policy, modular if empty; external, as with sim:=false if empty: one of your own publishes its commands",
    ),
    "repair": ("rss", "repair method"),
    "tuned": ("true", "whether the repair method takes the model and the settings that were made for the policy"),
    "clock": ("lockstep", "lockstep or realtime"),
    "rate": ("1.0", "real time: simulated seconds per wall second"),
    "seed": ("0", "of the repair method"),
    "out": ("bags", "folder for the bag"),
    "name": ("", "name of the bag, which must not exist; made of the scenario and the time if empty"),
    "record": ("true", "whether a bag is recorded"),
    "viz": ("", "whether markers and frames are published; true if empty, and false with sim:=false"),
    "foxglove": ("", "port of the live server for Foxglove; none if empty"),
    "sim": (
        "true",
        "whether the simulator of roadmend drives; false: ego, objects and commands come from your own nodes",
    ),
    "objects_type": ("roadmend_msgs/msg/ObjectList", "with sim:=false, the type of your objects"),
    "command_type": ("roadmend_msgs/msg/Command", "with sim:=false, the type of your commands"),
    "sim_time": ("false", "with sim:=false, whether your time comes from /clock"),
    "namespace": ("", "of all nodes"),
    "remap": ("", "topics under other names, as FROM:=TO, with blanks between"),
    "params_file": ("", "YAML file with parameters of the nodes, after those of the launch file"),
    "log_level": ("info", "of all nodes"),
}


def nodes(context: LaunchContext) -> list:
    """Make the nodes from the arguments as they are now."""
    given = {name: LaunchConfiguration(name).perform(context) for name in ARGUMENTS}
    simulated = is_yes("sim", given["sim"])
    if simulated and not given["scenario"]:
        raise RuntimeError("scenario: missing; give one, as scenario:=s.yaml, or sim:=false for a graph of your own")
    policy = given["policy"] or ("modular" if simulated else "external")
    viz = given["viz"] or ("true" if simulated else "false")
    pace = {"clock": given["clock"], "rate": number("rate", given["rate"], float)}  # repair_node counts by it, too
    recorder, repair = {}, pace
    if not simulated:
        sim_time = is_yes("sim_time", given["sim_time"])
        recorder = {"time_source": "simulation" if sim_time else "system"}
        repair = {"inputs": "newest", "objects_type": given["objects_type"], "command_type": given["command_type"]}
        repair |= {"use_sim_time": True} if sim_time else {}
    parameters = {
        "recorder": {"output": given["out"], "name": given["name"] or named_now(given["scenario"]), **recorder},
        "viz": {},
        "foxglove": {"port": number("foxglove", given["foxglove"] or "0", int)},
        "policy": {"policy": policy},
        "repair": {"method": given["repair"], "seed": number("seed", given["seed"], int), **repair},
    }
    is_external = policy == "external"
    parameters["repair"] |= {
        "policy": policy if is_yes("tuned", given["tuned"]) else "",
        "trajectory": "optional" if is_external else "required",
        "writer": "policy_node" if simulated and not is_external else "",
    }
    wanted = {
        "recorder": is_yes("record", given["record"]),
        "viz": is_yes("viz", viz),
        "foxglove": bool(given["foxglove"]),
        "policy": not is_external,
        "repair": True,
    }
    parts = {name: node(name, parameters[name], given) for name in parameters if wanted[name]}
    started = [*parts.values()]
    if simulated:
        waited_for = [f"{name}_node" for name in parts]
        own = {"scenario": given["scenario"], **pace, "writer": "repair_node"}
        own |= {"driver": "external" if is_external else "own"}
        simulator = node("sim", own | {"wait_for": waited_for}, given)
        over = OnProcessExit(target_action=simulator, on_exit=[EmitEvent(event=Shutdown(reason="the drive is over"))])
        started += [simulator, RegisterEventHandler(over)]
        if "recorder" in parts:  # the simulator would wait for it for ever; a vehicle of one's own keeps its repair
            lost = OnProcessExit(target_action=parts["recorder"], on_exit=ended_if_failed)
            started.append(RegisterEventHandler(lost))
    pairs = [pair.split(":=") for pair in given["remap"].split()]
    if any(len(pair) != 2 or not all(pair) for pair in pairs):
        raise RuntimeError(f"remap: {given['remap']!r} is no list of FROM:=TO; correct it")
    return [*(SetRemap(src=source, dst=target) for source, target in pairs), *started]


def is_yes(name: str, text: str) -> bool:
    """What an argument says; a misspelt one would start what nobody wants."""
    if text.lower() not in (*YES, *NO):
        raise RuntimeError(f"{name}: {text!r} is neither true nor false; write {name}:=true or {name}:=false")
    return text.lower() in YES


def number(name: str, text: str, kind: type) -> float:
    """The number that an argument holds, an ``int`` or a ``float``."""
    try:
        return kind(text)
    except ValueError:
        what = "whole number" if kind is int else "number"
        raise RuntimeError(f"{name}: {text!r} is no {what}; correct it") from None


def named_now(scenario: str) -> str:
    """The name of a bag that nobody named: the recorder takes no folder that exists, such as that of the last run."""
    return f"{Path(scenario).stem or 'recording'}-{time.strftime('%Y%m%d-%H%M%S')}"


def ended_if_failed(event: ProcessExited, _context: LaunchContext) -> EmitEvent | None:
    """The end of the run, where a process failed."""
    if not event.returncode:
        return None
    return EmitEvent(event=Shutdown(reason=f"the recorder failed ({event.returncode})"))


def node(name: str, parameters: dict, given: dict[str, str]) -> Node:
    """One node of the package; a file of parameters stands behind ours, and so wins."""
    files = [given["params_file"]] if given["params_file"] else []
    return Node(
        package="roadmend",
        executable=f"{name}_node",
        name=f"{name}_node",
        namespace=given["namespace"],
        parameters=[parameters, *files],
        ros_arguments=["--log-level", given["log_level"]],
        output="screen",
    )


def generate_launch_description() -> LaunchDescription:
    """Declare the arguments, then start the nodes."""
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=meaning)
        for name, (default, meaning) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])
