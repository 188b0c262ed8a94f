"""One episode in this process, with whoever drives and repairs; recorded where that is wanted."""

import json
import sys
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

from roadmend.api.given import PolicyLike, RepairLike, Settings, method_of, name_of, policy_of, settings_of, title_of
from roadmend.api.scenarios import ScenarioLike, scenario_of
from roadmend.core.command import Decision
from roadmend.core.episode_result import EpisodeResult
from roadmend.core.errors import InputError
from roadmend.core.registry import Found, Registry
from roadmend.core.repair import Repair
from roadmend.core.tick import Tick
from roadmend.measures.answering import Answering
from roadmend.measures.fitting import driver_of, fitting
from roadmend.nodes.provenance import described, provenance
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.recording.episode_recorder import EpisodeRecorder, account_of
from roadmend.recording.layout import RECORD
from roadmend.recording.new_bag import new_bag
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.registry import METHOD_REGISTRY
from roadmend.world.network import network_file
from roadmend.world.road_network import lanes_of, read_network
from roadmend.world.runner import Watcher, run_episode
from roadmend.world.scenario_file import dump_scenario


def run(
    scenario: ScenarioLike,
    policy: PolicyLike = "modular",
    repair: RepairLike = "rss",
    *,
    policy_parameters: Settings | None = None,
    repair_parameters: Settings | None = None,
    seed: int = 0,
    watch: Watcher | None = None,
    bag: str | PathLike[str] | None = None,
) -> EpisodeResult:
    """Drive a scenario to its end; the same arguments give the same trajectory, bit for bit, as the graph does.

    Args:
        scenario: what to drive, or the path of its file.
        policy: who drives: a name, a class, or an object.
        repair: the repair method: a name, a class, or an object; "none" leaves the policy alone.
        policy_parameters: what differs from the policy's defaults.
        repair_parameters: what differs from the method's defaults; these are, where both are named, the model and the
            settings that were made for the policy, or for the model that ``policy_parameters`` names.
        seed: for methods that draw numbers.
        watch: called at every tick before the vehicle moves, with the tick, the policy's decision and the repair.
        bag: a folder to record the episode into, which must not be there yet.

    Raises:
        InputError: an argument is unusable.
        ForeignError: a policy from outside failed on the way.
        RoadmendError: the repair method failed on the way, so that the guard had to answer for it.
        RecordingError: the bag cannot be written.
        SimulationError: SUMO failed.
    """
    chosen = scenario_of(scenario)
    driving = settings_of("policy_parameters", policy_parameters)
    repairing = settings_of("repair_parameters", repair_parameters)
    driver = policy_of(policy, driving)
    if isinstance(policy, str) and isinstance(repair, str):
        repairing = fitting(repair, driver_of(policy, driving)) | repairing
    method = method_of(repair, repairing, seed)
    repairer = Answering(GuardedRepairer(method))
    if bag is None:
        result = run_episode(chosen, driver, repairer, watch)
    else:
        account = provenance(Path(f"{chosen.name}.yaml"), ()) | {"clock": "lockstep", "seed": str(seed)}
        account |= _described("policy", POLICY_REGISTRY, policy, driver, driving)
        account |= _described("method", METHOD_REGISTRY, repair, method, repairing)
        with new_bag(Path(bag)) as writer:
            lanes = lanes_of(read_network(network_file(chosen.network)))
            recorder = EpisodeRecorder(writer, lambda _time: account["method"], lanes)
            text = dump_scenario(chosen).encode()
            writer.add_attachment(account["scenario_file"], "application/yaml", text)
            answered = recorder.answered if watch is None else partial(_both, recorder.answered, watch)
            result = run_episode(chosen, driver, repairer, answered, recorder.ended, recorder.opened)
            writer.add_metadata(RECORD, account | account_of(result, writer.count))
    return result


def _both(record: Watcher, watch: Watcher, tick: Tick, decision: Decision, repair: Repair) -> None:
    record(tick, decision, repair)
    watch(tick, decision, repair)


def _described(role: str, registry: Registry[Any], given: object, made: object, values: Settings) -> dict[str, str]:
    """What the bag says of who drives or repairs, by the names that the graph's bags have for it."""
    known = {role: title_of(given)}
    try:
        found = registry.find(name_of(given)) if name_of(given) else None
    except InputError:  # a class that can be driven with, but not asked for by name
        found = None
    if found is None:  # of an object, its class tells no parameters
        found = _found_of(given if isinstance(given, type) else type(given))
    else:
        values = found.entry.parameters(**values).model_dump(mode="json")  # of numpy's numbers as well
        known[f"{role}_parameters"] = json.dumps(values)
    return known | {f"{role}_{name}": value for name, value in described(found, made, values).items()}


def _found_of(kind: type) -> Found[Any]:
    module = kind.__module__
    source = getattr(sys.modules.get(module), "__file__", None) or module
    return Found(title_of(kind), kind.__name__, None, str(source), (module,))
