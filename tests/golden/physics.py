"""Golden trajectories: what the world, the policies and the repair methods do, held to the bit.

    .venv/bin/python tests/golden/physics.py            # drive all episodes again and show what moved
    .venv/bin/python tests/golden/physics.py --write    # the same, and keep what came out
    .venv/bin/python tests/golden/physics.py neural     # only the episodes with this in their name

An episode's record holds three digests, of the ego's trajectory, of all that was seen, and of all that was repaired and
why, beside a coarse trace by which a change can be told.
"""

import argparse
import hashlib
import json
import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from roadmend.core.whole_file import write_text
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.corpus import Case
from roadmend.world.families import FAMILIES
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_actors import Pedestrian, Vehicle
from roadmend.world.scenario_file import load_scenario

HERE = Path(__file__).parent
FILE = HERE / "trajectories.json"
CORPORA = HERE.parents[1] / "config" / "corpora"
POLICIES = ("modular", "neural")
METHODS = ("none", "rss", "predictive", "adreft")
OTHERS = (("modular", "rule"), ("modular", "model"), ("modular", "random"), ("deep_sets", "none"), ("ego_mlp", "none"))
TRACE = 20  # ticks between two entries of the trace: one second
DIGESTS = ("trajectory", "scenes", "repairs")


@dataclass(frozen=True)
class Golden:
    """One episode that is held."""

    name: str
    scenario: Scenario
    policy: str
    method: str

    @property
    def parameters(self) -> dict[str, str]:
        """ADReFT runs the model that was trained beside the policy, with precaution: it has more to say."""
        return {"model": f"precaution-{self.policy}"} if self.method == "adreft" else {}


def is_crowded(scenario: Scenario) -> bool:
    """Whether reckless drivers meet several pedestrians, whom SUMO keeps in the order of their pointers."""
    drivers = [actor.driver for actor in scenario.actors if isinstance(actor, Vehicle)]
    return "reckless" in drivers and sum(isinstance(actor, Pedestrian) for actor in scenario.actors) >= 2


@cache
def _lines(policy: str) -> list[str]:
    """A corpus's cases as they are written; to read all of them would take seconds."""
    return (CORPORA / f"{policy}.jsonl").read_text(encoding="utf-8").splitlines()[1:]


def _first(policy: str, family: str, *, violation: bool) -> Scenario:
    lines = (line for line in _lines(policy) if _is_for_training(line, family))
    cases = (case for line in lines if (case := Case.parse(line)).is_violation == violation)
    return next(cases).scenario()


def _is_for_training(line: str, family: str) -> bool:
    told = json.loads(line)
    return (told["family"], told["split"]) == (family, "training")


def episodes() -> Iterator[Golden]:
    """All episodes.

    A violation and a success of each family and policy, a crash report's scenario, a user's town; and the policies and
    methods beside the main ones, in one violation of each family.
    """
    for policy in POLICIES:
        for family in FAMILIES:
            for violation, methods in ((True, METHODS), (False, ("none", "adreft"))):
                scenario = _first(policy, family, violation=violation)
                for method in methods:
                    kind = "violation" if violation else "success"
                    yield Golden(f"{family}-{kind}-{policy}-{method}", scenario, policy, method)
        for name in ("crash-report", "town"):
            for method in ("none", "adreft"):
                yield Golden(f"{name}-{policy}-{method}", load_scenario(HERE / f"{name}.yaml"), policy, method)
    for family in FAMILIES:
        scenario = _first(POLICIES[0], family, violation=True)
        for policy, method in OTHERS:
            yield Golden(f"{family}-violation-{policy}-{method}", scenario, policy, method)


def drive(golden: Golden) -> dict[str, object]:
    """Drive an episode; its record as plain values."""
    scenes, repairs = hashlib.sha256(), hashlib.sha256()
    trace: list[list[float]] = []

    def watch(tick, decision, repair) -> None:
        scene, objects = tick.scene, tick.scene.objects
        columns = (
            objects.x,
            objects.y,
            objects.yaw,
            objects.speed,
            objects.acceleration,
            objects.yaw_rate,
            objects.length,
            objects.width,
        )
        scenes.update(struct.pack("<3d", scene.time, tick.min_distance, scene.ego.yaw_rate))
        scenes.update(bytes(map(int, objects.kind)) + bytes(map(int, scene.signals)))
        for column in columns:
            scenes.update(column.astype("<f8").tobytes())
        told = (repair.score, repair.threshold, repair.policy_action, repair.repair_action, repair.final_action)
        repairs.update(struct.pack("<5d2B", *told, int(repair.status), repair.intervened))
        repairs.update(repr([(each.object_id, each.weight) for each in repair.triggers]).encode())
        if tick.number % TRACE == 0:
            ego = scene.ego
            values = (scene.time, ego.x, ego.y, ego.yaw, ego.speed, repair.policy_action, repair.final_action)
            trace.append([round(value, 4) for value in values])

    repairer = make_repairer(golden.method, golden.parameters, seed=1)
    summary = run_episode(golden.scenario, make_policy(golden.policy), repairer, watch)
    return {
        "outcome": summary.outcome.name,
        "text": summary.text,
        "ticks": summary.ticks,
        "interventions": summary.interventions,
        "dose": round(summary.dose, 6),
        "trajectory": summary.digest,
        "scenes": scenes.hexdigest(),
        "repairs": repairs.hexdigest(),
        "trace": trace,
    }


def load() -> dict[str, dict[str, object]]:
    """The records that are kept, by name."""
    return json.loads(FILE.read_text(encoding="utf-8"))


def difference(kept: dict[str, object], found: dict[str, object]) -> str:
    """What moved from one record to another, in a line; empty if nothing did."""
    if kept == found:
        return ""
    moved = [name for name in kept if kept[name] != found[name] and name != "trace"]
    parts = [", ".join(moved) or "trace"]
    if kept["text"] != found["text"]:
        parts.append(f"{kept['text']!r} became {found['text']!r}")
    pairs = zip(kept["trace"], found["trace"], strict=False)
    first = next(((old, new) for old, new in pairs if old != new), None)
    if first is not None:
        names = ("t", "x", "y", "yaw", "speed", "asked", "sent")
        seen = [f"{name} {a} -> {b}" for name, a, b in zip(names, *first, strict=True) if a != b]
        parts.append(f"by {first[0][0]:g} s: " + ", ".join(seen))
    elif kept["ticks"] == found["ticks"]:
        parts.append("less than the trace shows")
    return "; ".join(parts)


def main() -> int:
    """Drive again, compare, and keep if asked."""
    from rich.progress import track

    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("part", nargs="?", default="", help="only episodes with this in their name")
    parser.add_argument("--write", action="store_true", help="keep what comes out as the new golden records")
    options = parser.parse_args()
    kept = load() if FILE.exists() else {}
    chosen = [golden for golden in episodes() if options.part in golden.name]
    found = {golden.name: drive(golden) for golden in track(chosen, "driving")}
    moved = 0
    for name, record in found.items():
        change = difference(kept[name], record) if name in kept else "is new"
        if change:
            moved += 1
            print(f"{name}: {change}")
    gone = [] if options.part else [name for name in kept if name not in found]
    print(f"{len(found)} driven, {moved} moved, {len(gone)} no longer there")
    if options.write:
        records = {**(kept if options.part else {}), **found}
        lines = ",\n".join(f" {json.dumps(name)}: {json.dumps(record)}" for name, record in sorted(records.items()))
        write_text(FILE, "{\n" + lines + "\n}\n")
    return 1 if (moved or gone) and not options.write else 0


if __name__ == "__main__":
    sys.exit(main())
