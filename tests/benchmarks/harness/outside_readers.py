"""What readers that others wrote see in an exported scenario: ASAM's two checkers, pyxodr, CommonRoad's converter.

Each is an optional package and imported where it is asked; which one is not there is for the caller to say.
"""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class SeenRoad(NamedTuple):
    """A road outside of junctions."""

    lanes: int  # for driving
    heading: float  # [deg] where it begins, counter-clockwise from east
    turn: float  # [deg] from its beginning to its end, left is positive
    line: NDArray[np.float64]  # (n, 2), [m]


def roads_by_pyxodr(path: Path) -> Iterator[SeenRoad]:
    """The roads of an OpenDRIVE file as pyxodr has them.

    Raises:
        ImportError: pyxodr is not installed.
    """
    from pyxodr.road_objects.network import RoadNetwork

    for road in RoadNetwork(str(path), resolution=0.5).get_roads():
        if road.road_xml.get("junction") == "-1":
            line = road.reference_line[:, :2]
            lanes = [lane for section in road.lane_sections for lane in section.lanes if lane.type == "driving"]
            yield SeenRoad(len(lanes), *headings(line), line)


def lines_by_commonroad(path: Path) -> list[NDArray[np.float64]]:
    """The centre lines, (n, 2) [m], of all lanelets that CommonRoad's converter makes of an OpenDRIVE file.

    Raises:
        ImportError: commonroad-scenario-designer is not installed.
    """
    from crdesigner.map_conversion.map_conversion_interface import opendrive_to_commonroad

    read = opendrive_to_commonroad(path)
    network = (read[0] if isinstance(read, tuple) else read).lanelet_network
    return [lanelet.center_vertices for lanelet in network.lanelets]


def issues_by_asam_opendrive(path: Path, work: Path) -> tuple[list[str], int]:
    """What ASAM's checker finds in an OpenDRIVE file, and how many of its checks it made.

    Raises:
        ImportError: asam-qc-opendrive is not installed.
    """
    from qc_opendrive import constants
    from qc_opendrive.main import run_checks

    return _issues(constants, run_checks, path, work)


def issues_by_asam_openscenario(path: Path, work: Path) -> tuple[list[str], int]:
    """The same for an OpenSCENARIO file.

    Raises:
        ImportError: asam-qc-openscenarioxml is not installed.
    """
    from qc_openscenario import constants
    from qc_openscenario.main import run_checks

    return _issues(constants, run_checks, path, work)


def _issues(constants: Any, run_checks: Any, path: Path, work: Path) -> tuple[list[str], int]:
    from qc_baselib import Configuration, Result, StatusType

    configuration, result = Configuration(), Result()
    configuration.set_config_param("InputFile", str(path))
    configuration.register_checker_bundle(constants.BUNDLE_NAME)
    configuration.set_checker_bundle_param(constants.BUNDLE_NAME, "resultFile", str(work / "result.xqar"))
    result.register_checker_bundle(name=constants.BUNDLE_NAME, description="", version="1.0.0", summary="")
    run_checks(configuration, result)
    checkers = result.get_checker_results(constants.BUNDLE_NAME)
    found = [issue.description for checker in checkers for issue in checker.issues]
    return found, sum(checker.status is StatusType.COMPLETED for checker in checkers)


def headings(line: NDArray[np.float64]) -> tuple[float, float]:
    """Heading at the start and turn to the end [deg] of a line, (n, 2)."""
    steps = np.diff(line, axis=0)
    steps = steps[np.hypot(*steps.T) > 1e-3]
    angles = np.unwrap(np.arctan2(steps[:, 1], steps[:, 0]))
    return math.degrees(angles[0]), math.degrees(angles[-1] - angles[0])
