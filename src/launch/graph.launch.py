"""The whole graph: ``ros2 launch roadmend graph.launch.py scenario:=s.yaml repair:=adreft``.

Every node of a run, under a namespace and with remappings if they are given. The run ends when the simulator does.
``roadmend run`` does the same without launch, and beyond it restarts a node that dies and ends one that hangs.

``sim:=false`` starts repair and recorder beside nodes of your own, as ``roadmend repair`` does: their odometry, objects
and commands come under any name (``remap``), at any rate.
"""

from launch.actions import DeclareLaunchArgument, EmitEvent, OpaqueFunction, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, SetRemap

from launch import LaunchContext, LaunchDescription

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
    "name": ("recording", "name of the bag"),
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
    simulated = given["sim"].lower() not in NO
    if simulated and not given["scenario"]:
        raise RuntimeError("scenario: missing; give one, as scenario:=s.yaml, or sim:=false for a graph of your own")
    policy = given["policy"] or ("modular" if simulated else "external")
    viz = given["viz"] or ("true" if simulated else "false")
    time = {"clock": given["clock"], "rate": float(given["rate"])}  # the simulator's, and repair_node counts by it
    recorder, repair = {}, time
    if not simulated:
        sim_time = given["sim_time"].lower() not in NO
        recorder = {"time_source": "simulation" if sim_time else "system"}
        repair = {"inputs": "newest", "objects_type": given["objects_type"], "command_type": given["command_type"]}
        repair |= {"use_sim_time": True} if sim_time else {}
    parameters = {
        "recorder": {"output": given["out"], "name": given["name"], **recorder},
        "viz": {},
        "foxglove": {"port": int(given["foxglove"] or 0)},
        "policy": {"policy": policy},
        "repair": {"method": given["repair"], "seed": int(given["seed"]), **repair},
    }
    is_external = policy == "external"
    parameters["repair"] |= {
        "policy": policy if given["tuned"].lower() not in NO else "",
        "trajectory": "optional" if is_external else "required",
        "writer": "policy_node" if simulated and not is_external else "",
    }
    wanted = {
        "recorder": given["record"].lower() not in NO,
        "viz": viz.lower() not in NO,
        "foxglove": bool(given["foxglove"]),
        "policy": not is_external,
        "repair": True,
    }
    started = [node(name, parameters[name], given) for name in parameters if wanted[name]]
    if simulated:
        waited_for = [f"{name}_node" for name in parameters if wanted[name]]
        own = {"scenario": given["scenario"], **time, "writer": "repair_node"}
        own |= {"driver": "external" if is_external else "own"}
        simulator = node("sim", own | {"wait_for": waited_for}, given)
        over = OnProcessExit(target_action=simulator, on_exit=[EmitEvent(event=Shutdown(reason="the drive is over"))])
        started += [simulator, RegisterEventHandler(over)]
    pairs = [pair.split(":=") for pair in given["remap"].split()]
    if any(len(pair) != 2 for pair in pairs):
        raise RuntimeError(f"remap: {given['remap']!r} is no list of FROM:=TO; correct it")
    return [*(SetRemap(src=source, dst=target) for source, target in pairs), *started]


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
