"""``roadmend bench exports``: what readers that others wrote see in the exported scenarios of crash reports."""

import hashlib
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click

from harness import outside_readers
from harness.figures import Figures
from roadmend.cli.options import JSON, WORKERS
from roadmend.cli.output import counting
from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.reports.result_files import provenance
from roadmend.safe.cases import CrashCase, gather_cases
from roadmend.safe.construction import draw_scenario, roles_of
from roadmend.safe.dsl import DescribedRoadNetwork, RoadType
from roadmend.safe.openscenario import export_scenario
from roadmend.world.scenario import Scenario
from roadmend.world.scenario_networks import IntersectionNetwork, OpenRoadNetwork

_PACKAGES = {  # that a reader is in, by its name
    "ASAM OpenSCENARIO checker": "qc_openscenario",
    "ASAM OpenDRIVE checker": "qc_opendrive",
    "pyxodr": "pyxodr",
    "CommonRoad": "crdesigner",
}
_TURN, _COARSE_TURN = 1.0, 5.0  # [deg] by which a bend may differ; CommonRoad's lines are coarse
_BENT = 5.0  # [deg] from which on a road is no longer straight

Seen = dict[str, Any]  # what a reader saw of one file


@click.command()
@click.argument("reports", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for exports.json and exports.md.")
@WORKERS
@JSON
def exports(reports: tuple[Path, ...], out: Path | None, workers: int, *, as_json: bool) -> None:
    """Build each vehicle's scenario of crash reports, export it, and open it in other people's readers.

    Their packages are asked where they are installed: asam-qc-opendrive, asam-qc-openscenarioxml, pyxodr,
    commonroad-scenario-designer.
    """
    cases = gather_cases(reports)
    readable = [case for case in cases if case.crash is not None]
    if not readable:
        raise InputError(str(reports[0]), "not one crash could be read", "see 'roadmend safe extract'")
    there = [name for name, package in _PACKAGES.items() if find_spec(package) is not None]
    with (
        counting() as progress,
        fan_out(workers, len(readable)) as mapper,
    ):
        answers = mapper(partial(_seen_of, there), readable)
        seen = [*progress.track(answers, len(readable), description="reports")]
    content = {
        "format": "roadmend-exports/1",
        "provenance": provenance("./roadmend bench exports REPORTS"),
        "reports": len(cases),
        "built": len(readable),
        "readers": {name: _figures([one for each in seen for one in each[name]]) for name in there},
        "not_installed": [name for name in _PACKAGES if name not in there],
    }
    Figures("exports", "Exported crashes in other people's readers", content, _rows(content)).publish(
        out, as_json=as_json
    )


def _seen_of(readers: Sequence[str], case: CrashCase) -> dict[str, list[Seen]]:
    """What the readers see of one report: a file for each of its roles, the roads once where they are the same."""
    assert case.crash is not None
    found: dict[str, list[Seen]] = {name: [] for name in readers}
    roads: set[str] = set()
    with tempfile.TemporaryDirectory(prefix="roadmend-") as name:
        for number, role in enumerate(roles_of(case.name, case.crash)):
            folder = Path(name) / str(number)
            folder.mkdir()
            scenario = draw_scenario(role, 0)
            description, road = export_scenario(scenario, folder)
            digest = hashlib.sha256(road.read_bytes()).hexdigest()
            for reader in readers:
                if reader == "ASAM OpenSCENARIO checker":
                    found[reader].append(
                        _opened(partial(_checked, outside_readers.issues_by_asam_openscenario, description))
                    )
                elif digest not in roads:
                    found[reader].append(_opened(partial(_ROADS[reader], road, scenario, case.crash.road)))
            roads.add(digest)
    return found


def _opened(read: Callable[[], Seen]) -> Seen:
    try:
        return {"opened": True, **read()}
    except Exception as error:  # noqa: BLE001 - of somebody else's program; whatever it is, the file did not open
        return {"opened": False, "problem": f"{type(error).__name__}: {error}"}


def _checked(check: Callable[[Path, Path], tuple[list[str], int]], path: Path) -> Seen:
    issues, checks = check(path, path.parent)
    return {"opened": checks > 0 and not issues, "problem": "; ".join(issues), "checks": checks}


def _checked_roads(path: Path, _scenario: Scenario, _road: DescribedRoadNetwork) -> Seen:
    return _checked(outside_readers.issues_by_asam_opendrive, path)


def _by_pyxodr(path: Path, scenario: Scenario, told: DescribedRoadNetwork) -> Seen:
    roads = [*outside_readers.roads_by_pyxodr(path)]
    found: Seen = {}
    network = scenario.network
    if isinstance(network, OpenRoadNetwork):
        found["lanes"] = sum(road.lanes for road in roads) == network.lanes + network.backward_lanes
        found["bend"] = _is_bend_right([(road.heading, road.turn) for road in roads], network, told, _TURN)
        if told.lanes is not None:
            found["lanes_as_told"] = sum(road.lanes for road in roads) == told.lanes
    elif isinstance(network, IntersectionNetwork):
        arms = sum(arm.lanes + (arm.lanes if arm.lanes_out is None else arm.lanes_out) for arm in network.arms)
        found["lanes"] = sum(road.lanes for road in roads) == arms
        found["bend"] = all(abs(road.turn) <= _TURN for road in roads)
    return found


def _by_commonroad(path: Path, scenario: Scenario, told: DescribedRoadNetwork) -> Seen:
    lines = outside_readers.lines_by_commonroad(path)
    found: Seen = {} if lines else {"opened": False, "problem": "no lanelet"}
    network = scenario.network
    if lines and isinstance(network, OpenRoadNetwork):
        found["lanes"] = len(lines) == network.lanes + network.backward_lanes
        found["bend"] = _is_bend_right([*map(outside_readers.headings, lines)], network, told, _COARSE_TURN)
        if told.lanes is not None:
            found["lanes_as_told"] = len(lines) == told.lanes
    return found


def _is_bend_right(
    ways: Sequence[tuple[float, float]], network: OpenRoadNetwork, told: DescribedRoadNetwork, within: float
) -> bool:
    """Whether every line turns as the road was built, and the road is straight where the report says so.

    A line runs along the road or against it; which of them says the heading where it begins, and so to which side it
    must turn: a bend that is mirrored has the right angle.

    Args:
        ways: of each line the heading where it begins and the turn to its end [deg], left is positive.
        network: as it was built.
        told: as the report has it.
        within: by how much both may differ [deg].
    """
    built = ((network.bearing, network.bend), (network.bearing + network.bend + 180.0, -network.bend))
    as_built = all(
        any(
            abs((heading - begin + 180.0) % 360.0 - 180.0) <= within and abs(turn - bend) <= within
            for begin, bend in built
        )
        for heading, turn in ways
    )
    is_bent = max(abs(turn) for _, turn in ways) > _BENT
    return as_built and is_bent is (told.road_type is RoadType.CURVE)


_ROADS: dict[str, Callable[[Path, Scenario, DescribedRoadNetwork], Seen]] = {
    "ASAM OpenDRIVE checker": _checked_roads,
    "pyxodr": _by_pyxodr,
    "CommonRoad": _by_commonroad,
}
_NONE = "\N{EN DASH}"
_COMPARED = ("lanes", "lanes_as_told", "bend")


def _figures(seen: Sequence[Seen]) -> dict[str, Any]:
    compared = {key: [one[key] for one in seen if key in one] for key in _COMPARED}
    return {
        "files": len(seen),
        "opened": sum(one["opened"] for one in seen),
        "problems": sorted({one["problem"] for one in seen if not one["opened"]}),
        **{key: {"compared": len(values), "right": sum(values)} for key, values in compared.items()},
    }


def _rows(content: Mapping[str, Any]) -> list[list[str]]:
    rows = [["reader", "files", "opened", "lanes as built", "lanes as told", "bend"]]
    for name, figures in content["readers"].items():
        rows.append([name, str(figures["files"]), str(figures["opened"]), *_shares(figures)])
    return [*rows, *([name, "not installed", *[_NONE] * 4] for name in content["not_installed"])]


def _shares(figures: Mapping[str, Any]) -> Iterator[str]:
    for key in _COMPARED:
        counts = figures[key]
        yield f"{counts['right']} of {counts['compared']}" if counts["compared"] else _NONE
