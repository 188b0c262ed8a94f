"""``roadmend bench loop``: what the loop costs beside bare SUMO and beside a bare ring of nodes."""

import itertools
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import Progress

from harness.bare_stepping import recorded_orders, time_bare_stepping
from harness.figures import Figures
from harness.processes import node_environment
from roadmend.core.errors import RoadmendError
from roadmend.core.tick import INTERVAL
from roadmend.nodes.domain import own_domain
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.reports.result_files import provenance
from roadmend.world.families import FAMILIES, sample_scenario
from roadmend.world.runner import run_episode
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_file import save_scenario

# Bytes of one tick's messages on each hop of the graph with 20 objects: scene, decision, repair.
_HOP_BYTES = (20 * 69 + 900, 4 * 16 * 8 + 200, 300)
_OBJECTS = 20


@dataclass(frozen=True)
class Ratio:
    """Ratios of paired measurements."""

    values: tuple[float, ...]

    @property
    def median(self) -> float:
        """The figure to quote."""
        return statistics.median(self.values)

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return {"median": self.median, "min": min(self.values), "max": max(self.values), "pairs": len(self.values)}


@click.command()
@click.option(
    "--scenarios", default=4, show_default=True, type=click.IntRange(1, 100), help="Scenarios of each family."
)
@click.option("--repeats", default=3, show_default=True, type=click.IntRange(1, 50), help="Pairs of graph and ring.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for loop.json and loop.md.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def loop(scenarios: int, repeats: int, out: Path | None, *, as_json: bool) -> None:
    """In-process loop beside bare SUMO; lockstep graph beside a bare ring of rclpy nodes."""
    console = Console(stderr=True)
    with Progress(console=console) as progress:
        task = progress.add_task("loop", total=scenarios * len(FAMILIES) + repeats)
        advance = lambda: progress.advance(task)
        in_process = _in_process(scenarios, advance)
        graph = _graph(repeats, advance)
    content = {"provenance": provenance(f"./roadmend bench loop --scenarios {scenarios} --repeats {repeats}")}
    content |= {"in_process": in_process, "graph": graph}
    Figures("loop", "Cost of the loop", content, _rows(in_process, graph)).publish(out, as_json=as_json)


def _in_process(scenarios: int, advance: Callable[[], None]) -> dict[str, Any]:
    policy, repairer = make_policy("modular"), make_repairer("none")
    run_episode(sample_scenario("S3", 0), policy, repairer)  # compiles, loads
    families: dict[str, Any] = {}
    every: list[float] = []
    for family in FAMILIES:
        ratios, costs, bare_costs = [], [], []
        for scenario in _dense(family, scenarios):
            with recorded_orders() as script:
                run_episode(scenario, policy, repairer)
            ticks, stepping = _time_loop(scenario, policy, repairer)
            bare = time_bare_stepping(scenario, script)
            ratios.append(stepping / bare)
            costs.append(stepping / ticks)
            bare_costs.append(bare / ticks)
            advance()
        every += ratios
        families[family] = {
            "ratio": Ratio(tuple(ratios)).as_dict(),
            "microseconds_per_tick": 1e6 * statistics.median(costs),
            "bare_microseconds_per_tick": 1e6 * statistics.median(bare_costs),
        }
    return {"ratio": Ratio(tuple(every)).as_dict(), "families": families}


def _dense(family: str, count: int) -> list[Scenario]:
    """The first scenarios of a family from seed 1000 on with at least twenty others on the road."""
    every = (sample_scenario(family, seed) for seed in itertools.count(1000))
    return list(itertools.islice((scenario for scenario in every if len(scenario.actors) >= _OBJECTS), count))


def _time_loop(scenario: Scenario, policy: Any, repairer: Any) -> tuple[int, float]:
    """Ticks of an episode and the seconds that they took, start-up left out as it is for bare SUMO."""
    first, last = [0.0], [0.0]

    def watch(tick: Any, _decision: Any, _repair: Any) -> None:
        if tick.number == 0:
            first[0] = time.perf_counter()

    def end(_tick: Any) -> None:
        last[0] = time.perf_counter()

    summary = run_episode(scenario, policy, repairer, watch, end)
    return summary.ticks, last[0] - first[0]


def _graph(repeats: int, advance: Callable[[], None]) -> dict[str, Any]:
    scenario = _scenario_with(_OBJECTS)
    ratios, factors, recorded = [], [], []
    with tempfile.TemporaryDirectory(prefix="roadmend-bench-") as folder:
        path = Path(folder) / f"{scenario.name}.yaml"
        save_scenario(scenario, path)
        for repeat in range(repeats):
            bare = _ring_seconds_per_round(1000)
            plain = run_graph(GraphOptions(path, method="none", record=False, viz=False))
            factors.append(plain.real_time_factor)
            ratios.append(INTERVAL / plain.real_time_factor / bare)
            full = run_graph(GraphOptions(path, method="none", bags=Path(folder), name=f"bag-{repeat}"))
            recorded.append(full.real_time_factor)
            advance()
    return {
        "scenario": scenario.name,
        "ratio_to_ring": Ratio(tuple(ratios)).as_dict(),
        "real_time_factor": Ratio(tuple(factors)).as_dict(),
        "real_time_factor_recorded_with_viz": Ratio(tuple(recorded)).as_dict(),
    }


def _scenario_with(vehicles: int) -> Scenario:
    """The first dense intersection with as many vehicles."""
    for seed in range(2000, 4000):
        scenario = sample_scenario("S3", seed)
        if len(scenario.actors) == vehicles and all(actor.type == "vehicle" for actor in scenario.actors):
            return scenario
    raise RoadmendError(f"no scenario with {vehicles} vehicles found")


def _ring_seconds_per_round(rounds: int) -> float:
    """Mean time of a round in a ring of three processes that carries the graph's bytes on each hop."""
    with own_domain() as domain:
        environment = node_environment(domain)
        processes = []
        for place, count in enumerate(_HOP_BYTES):
            command = [sys.executable, "-m", "harness.ring", "--ros-args", "-r", f"__node:=ring_{place}"]
            for name, value in (("place", place), ("size", len(_HOP_BYTES)), ("bytes", count), ("rounds", rounds)):
                command += ["-p", f"{name}:={value}"]
            processes.append(
                subprocess.Popen(command, env=environment, stdout=subprocess.PIPE if place == 0 else subprocess.DEVNULL)
            )
        try:
            printed, _ = processes[0].communicate(timeout=120)
        finally:
            for process in processes[1:]:
                process.terminate()
                process.wait()
    if not printed:
        raise RoadmendError("the ring of nodes did not run; see 'roadmend bench loop --help'")
    return float(printed)


def _rows(in_process: dict[str, Any], graph: dict[str, Any]) -> list[list[str]]:
    def spread(ratio: dict[str, Any]) -> str:
        return f"{ratio['min']:.2f} .. {ratio['max']:.2f}"

    rows = [["what", "median", "spread", "per tick"]]
    for name, family in in_process["families"].items():
        cost = f"{family['microseconds_per_tick']:.0f} us, SUMO {family['bare_microseconds_per_tick']:.0f} us"
        rows.append(
            [f"{name} in process / bare SUMO", f"{family['ratio']['median']:.2f} x", spread(family["ratio"]), cost]
        )
    rows.append(
        ["all in process / bare SUMO", f"{in_process['ratio']['median']:.2f} x", spread(in_process["ratio"]), ""]
    )
    rows.append(
        ["lockstep graph / bare ring", f"{graph['ratio_to_ring']['median']:.2f} x", spread(graph["ratio_to_ring"]), ""]
    )
    for key, name in (
        ("real_time_factor", "graph"),
        ("real_time_factor_recorded_with_viz", "graph with recorder and viz"),
    ):
        factor = graph[key]
        rows.append(
            [
                f"{name}, real-time factor",
                f"{factor['median']:.1f} x",
                spread(factor),
                f"{1e3 * INTERVAL / factor['median']:.2f} ms",
            ]
        )
    return rows
