"""How a fault gets into a run: what ``roadmend run`` is told, who is put between its nodes, and which files it is given."""

import contextlib
import hashlib
import json
import math
import random
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from roadmend.core.command_age import CommandAge
from roadmend.core.repair import RepairStatus
from roadmend.core.resources import config_folder
from roadmend.core.tick import INTERVAL, INTERVAL_NS
from roadmend.faults.campaign import FaultCampaign, FaultTrial
from roadmend.faults.distortion import CLOCK, Distortion
from roadmend.faults.fault import RELAY, STRANGER, MethodFault, TopicFault
from roadmend.recording import topics
from roadmend.recording.messages import NANOSECONDS

TOUCHED = "touched.json"  # what the relay, or the method, leaves when it begins to disturb
_SILENCES = frozenset({RepairStatus.STALE_COMMAND.name, RepairStatus.STALE_OBJECTS.name})
METHOD = "adreft"  # whose model is spoilt
_MODEL = "adreft-modular.safetensors"
_FOREIGN_MODEL = "self_oracle-modular.safetensors"
_METHOD = '''"""A repair method that fails for a while; written by a campaign of faults."""

import math
import time
from pathlib import Path

from roadmend import Proposal


class Broken:
    """Has no opinion, but for the ticks in which it fails."""

    name = "broken"

    def reset(self, route):
        pass

    def propose(self, scene, decision):
        tick = round(scene.time / {interval!r})
        if tick not in {ticks!r}:
            return Proposal(0.0, 1.0, 1.0)
        Path({report!r}).touch()
        if {method!r} == "raises":
            raise RuntimeError("this method always fails here")
        if {method!r} == "overruns":
            time.sleep(0.04)
            return Proposal(0.0, 1.0, 1.0)
        return Proposal(math.nan, 1.0, -1.0)
'''


def begin_of(campaign: FaultCampaign, trial: FaultTrial) -> float:
    """The moment, drawn by the seed, at which a fault comes [s] of simulated time after the start."""
    assert trial.fault is not None
    numbers = random.Random(f"{trial.fault.name}/{trial.clock}/{trial.rate}/{trial.seed}")
    after = getattr(trial.fault, "after", 0.0)
    return after + numbers.uniform(0.0, 1.0) if after else numbers.uniform(campaign.earliest, campaign.latest)


def run_command(campaign: FaultCampaign, trial: FaultTrial, scenario: Path, folder: Path) -> list[str]:
    """The command line of the run, for a folder of its own."""
    fault = trial.fault
    command = [sys.executable, "-m", "roadmend.cli", "run", "--scenario", str(scenario), "--policy", campaign.policy]
    method, ros = campaign.repair, list[str]()
    if isinstance(fault, TopicFault):
        ros = _beside() if fault.is_stranger else _detour(fault.topic)
    if isinstance(fault, MethodFault):
        method, ros = _broken(campaign, trial, fault, folder)
    command += ["--repair", method, "--clock", trial.clock, "--rate", str(trial.rate), "--json"]
    command += ["--out", str(folder / "bags"), "--name", "bag"]
    if fault is None or getattr(fault, "node", "") != "viz":
        command += ["--no-viz"]
    return command + (["--ros-args", *ros] if ros else [])


def model_digests() -> list[str]:
    """SHA-256 of the files that the spoilt models are made of."""
    folder = config_folder() / "models"
    return [hashlib.sha256((folder / name).read_bytes()).hexdigest() for name in (_MODEL, _FOREIGN_MODEL)]


def distortion_of(campaign: FaultCampaign, trial: FaultTrial) -> Distortion:
    """What the relay of a run does to the messages of its topic."""
    fault = trial.fault
    assert isinstance(fault, TopicFault)
    begin, shift = round(begin_of(campaign, trial) / INTERVAL), round(fault.shift * NANOSECONDS)
    return Distortion(fault.distortion, begin, fault.ticks, fault.share, fault.late, shift, trial.seed)


def touched_stamps(campaign: FaultCampaign, trial: FaultTrial, folder: Path) -> list[int] | None:
    """Stamps [ns] of the ticks at which a fault must be declared, as far as that is known without the bag.

    A message that lacks alone is no silence where the next one comes before it counts as late, which at high rates of
    real time it does (``core.command_age``); of messages that lack now and then the first are given that are missed.

    Returns:
        In order; empty where nothing must be declared; None of a signal to a process.
    """
    fault = trial.fault
    if isinstance(fault, MethodFault):
        return [tick * INTERVAL_NS for tick in _failing_ticks(campaign, trial, fault)]
    if not isinstance(fault, TopicFault):
        return None
    if fault.share < 1.0:
        what = distortion_of(campaign, trial)
        ticks = range(what.begin, what.begin + what.ticks)
        if fault.declared in _SILENCES and trial.clock == "realtime":
            contract = CommandAge(is_lockstep=False, rate=trial.rate)
            in_a_row = math.floor(contract.patience / contract.tick) + 1
            first = what.first_in_a_row(fault.topic, in_a_row)
            return [] if first is None else [first * INTERVAL_NS]
        return [tick * INTERVAL_NS for tick in ticks if what.touches(fault.topic, tick)]
    with contextlib.suppress(OSError, json.JSONDecodeError, LookupError, TypeError, ValueError):
        first = int(json.loads((folder / TOUCHED).read_text(encoding="utf-8"))["first"])
        return [first + step * INTERVAL_NS for step in range(fault.ticks)]
    return []


def _failing_ticks(campaign: FaultCampaign, trial: FaultTrial, fault: MethodFault) -> list[int]:
    """Numbers of the ticks at which a method fails."""
    begin = round(begin_of(campaign, trial) / INTERVAL)
    return [tick for tick in range(begin, begin + fault.ticks) if random.Random(tick).random() < fault.share]


def relay(
    campaign: FaultCampaign, trial: FaultTrial, folder: Path, environment: Mapping[str, str]
) -> subprocess.Popen[bytes] | None:
    """The node that disturbs a topic, started; None where none is asked for.

    Args:
        campaign: the campaign.
        trial: the run.
        folder: its folder.
        environment: of the process, with the graph's domain.
    """
    fault = trial.fault
    if not isinstance(fault, TopicFault):
        return None
    distortion = distortion_of(campaign, trial)
    values = {
        "links": [fault.topic] if fault.is_stranger else _links(fault.topic),
        "distortion": distortion.name,
        "begin": distortion.begin,
        "ticks": distortion.ticks,
        "share": distortion.share,
        "late": distortion.late,
        "shift": distortion.shift / NANOSECONDS,
        "seed": distortion.seed,
        "report": str(folder / TOUCHED),
        "with_parent": True,  # a campaign that is killed leaves nobody who speaks on its topics
    }
    command = [sys.executable, "-m", "roadmend.nodes.relay", "--ros-args"]
    command += ["-r", f"__node:={fault.node}"]
    for name, value in values.items():
        command += ["-p", f"{name}:={json.dumps(value)}"]
    with (folder / "relay.log").open("wb") as log:
        return subprocess.Popen(command, stdout=log, stderr=log, env=dict(environment), start_new_session=True)


def _links(topic: str) -> list[str]:
    """What the relay listens to and publishes, as it takes it."""
    if topic == CLOCK:
        return [link for one in (topics.EGO, topics.OBJECTS, topics.REPAIR_COMMAND) for link in _links(one)]
    if topic in (topics.EGO, topics.OBJECTS):
        return [f"{topic}>{topic}>behind/{topic}"]
    return [f"{topic}>before/{topic}>{topic}"]


def _beside() -> list[str]:
    """ROS arguments by which the simulator waits for a stranger too."""
    return ["-p", f"sim_node:wait_for:={json.dumps(['recorder_node', 'policy_node', 'repair_node', STRANGER])}"]


def _detour(topic: str) -> list[str]:
    """ROS arguments by which a topic's messages go through the relay, and the relay is the writer that is obeyed.

    What lies behind the relay does not listen to the simulator itself, which therefore must not wait for that.
    """
    waited = ["recorder_node", "policy_node", "repair_node", RELAY]
    remaps: Sequence[tuple[str, str]] = []
    if topic in (topics.EGO, topics.OBJECTS):
        remaps, waited = [("repair_node", topic)], [name for name in waited if name != "repair_node"]
    elif topic == CLOCK:
        remaps = [(node, one) for node in ("policy_node", "repair_node") for one in (topics.EGO, topics.OBJECTS)]
        waited = ["recorder_node", RELAY]
    words = [f"{node}:{one}:=behind/{one}" for node, one in remaps]
    settings = [f"sim_node:wait_for:={json.dumps(waited)}"]
    if topic in (topics.POLICY_COMMAND, topics.POLICY_TRAJECTORY):
        words.append(f"policy_node:{topic}:=before/{topic}")
    if topic == topics.POLICY_COMMAND:
        settings.append(f"repair_node:writer:={RELAY}")
    if topic in (topics.REPAIR_COMMAND, CLOCK):
        words.append(f"repair_node:{topics.REPAIR_COMMAND}:=before/{topics.REPAIR_COMMAND}")
        settings.append(f"sim_node:writer:={RELAY}")
    return [*(part for word in words for part in ("-r", word)), *(part for one in settings for part in ("-p", one))]


def _broken(campaign: FaultCampaign, trial: FaultTrial, fault: MethodFault, folder: Path) -> tuple[str, list[str]]:
    """Name of the method and ROS arguments, after what they need has been written."""
    if fault.is_driven:
        text = _METHOD.format(
            interval=INTERVAL,
            ticks=_failing_ticks(campaign, trial, fault),
            report=str(folder / TOUCHED),
            method=fault.method,
        )
        (folder / "broken_method.py").write_text(text, encoding="utf-8")
        return "broken_method:Broken", []
    model = folder / "model.safetensors"
    content = (config_folder() / "models" / (_FOREIGN_MODEL if fault.method == "foreign" else _MODEL)).read_bytes()
    if fault.method == "changed":
        middle = len(content) // 2
        content = content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]
    if fault.method == "cut":
        content = content[: len(content) // 2]
    if fault.method != "missing":
        model.write_bytes(content)
    return METHOD, ["-p", f"repair_node:{METHOD}.model:={json.dumps(str(model))}"]
