"""``roadmend bench retrieval``: how fast and how well a large scenario bank finds what fits a failure."""

import random
import resource
import statistics
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any, get_args

import click

from harness.figures import Figures
from harness.generated import generate
from harness.retrieval import draw_patterns, recalls, time_searches
from roadmend.cli.sera_bank import build_progress
from roadmend.core.fanout import fan_out
from roadmend.reports.result_files import provenance
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.filters import Filters
from roadmend.world.scenario import Weather

_BANK_SEED, _PATTERN_SEED = 1, 2
_COUNT = 10
_WARM_UP = 20  # searches before the clock counts


@click.command()
@click.option("--scenarios", default=1_000_000, show_default=True, type=click.IntRange(100), help="In the bank.")
@click.option("--queries", default=1000, show_default=True, type=click.IntRange(10), help="Failure patterns.")
@click.option(
    "--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for retrieval.json and retrieval.md."
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def retrieval(scenarios: int, queries: int, out: Path | None, *, as_json: bool) -> None:
    """Search a bank of generated scenarios by failure patterns; compare with exact search."""
    content = {
        "provenance": provenance(f"./roadmend bench retrieval --scenarios {scenarios} --queries {queries}"),
        "n": scenarios,
        "queries": queries,
    }
    with tempfile.TemporaryDirectory(prefix="roadmend-bank-") as folder:
        path = Path(folder) / "generated.bank"
        # In a process of its own, so that its memory is told from that of searching.
        with fan_out(2) as mapper:
            content |= next(mapper(partial(_build, path), [scenarios]))
        content |= _search(path, queries)
    Figures("retrieval", "Retrieval from the scenario bank", content, _rows(content)).publish(out, as_json=as_json)


def _build(path: Path, scenarios: int) -> dict[str, Any]:
    began, worked = time.perf_counter(), time.process_time()
    with build_progress(scenarios) as report:
        build_bank(path, generate(scenarios, _BANK_SEED), report=report)
    return {
        "build_seconds": time.perf_counter() - began,
        "build_cpu_seconds": time.process_time() - worked,
        "build_peak_memory_bytes": _peak_memory(),
    }


def _search(path: Path, queries: int) -> dict[str, Any]:
    began = time.perf_counter()
    with Bank(path) as bank:
        opened = time.perf_counter() - began
        patterns = draw_patterns(queries, _PATTERN_SEED)
        generator = random.Random(_PATTERN_SEED)
        filters: dict[str, list[Filters | None]] = {"all": [None] * queries, "filtered by weather": []}
        for pattern in patterns:
            weather: str = pattern.where.weather or generator.choice(get_args(Weather))
            filters["filtered by weather"].append(Filters(weather=(weather,)))
        found: list[list[int]] = []
        searches: dict[str, dict[str, float]] = {}
        for name, each in filters.items():
            time_searches(bank, patterns[:_WARM_UP], each[:_WARM_UP], _COUNT)
            numbers, latencies = time_searches(bank, patterns, each, _COUNT)
            searches[name] = latencies.milliseconds()
            found += numbers
        peak = _peak_memory()
        every = [each for group in filters.values() for each in group]
        shares = recalls(bank, patterns * len(filters), every, found, _COUNT)
        for place, search in enumerate(searches.values()):
            search["recall_at_10"] = statistics.fmean(shares[place * queries : (place + 1) * queries])
        return {
            "open_seconds": opened,
            "peak_memory_bytes": peak,
            "index_bytes": bank.index.size,
            "file_bytes": path.stat().st_size,
            "dimensions": bank.embedder.dimensions,
            "distinct_vectors": len({hash(vector.tobytes()) for vector in bank.index.vectors}),
            "p95_ms": searches["all"]["p95_ms"],
            "recall_at_10": searches["all"]["recall_at_10"],
            "searches": searches,
        }


def _peak_memory() -> int:
    """Resident memory of this process at its most [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _rows(content: dict[str, Any]) -> list[list[str]]:
    rows = [
        ["what", "figure"],
        ["scenarios", f"{content['n']:,}"],
        ["failure patterns searched for", f"{content['queries']:,}"],
    ]
    for name, kind in content["searches"].items():
        wall = " / ".join(f"{kind[f'p{share}_ms']:.2f}" for share in (50, 95, 99))
        processor = " / ".join(f"{kind[f'cpu_p{share}_ms']:.2f}" for share in (50, 95, 99))
        rows += [
            [f"{name}: recall@10 against exact search", f"{kind['recall_at_10']:.4f}"],
            [f"{name}: one search on one core, p50 / p95 / p99", f"{wall} ms"],
            [f"{name}: processor time of it, p50 / p95 / p99", f"{processor} ms"],
        ]

    def megabytes(key: str) -> str:
        return f"{content[key] / 1e6:.0f} MB"

    rows += [
        [
            "building, drawing the scenarios included",
            f"{content['build_seconds']:.0f} s, {content['build_cpu_seconds']:.0f} s of processor time",
        ],
        ["memory of building, peak", megabytes("build_peak_memory_bytes")],
        ["opening", f"{content['open_seconds']:.1f} s"],
        ["memory of searching, peak", megabytes("peak_memory_bytes")],
        ["vectors and codes", f"{megabytes('index_bytes')}, {content['dimensions']} dimensions"],
        ["file", megabytes("file_bytes")],
        ["different vectors", f"{content['distinct_vectors']:,}"],
    ]
    return rows
