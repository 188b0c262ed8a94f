"""A network without traffic, as netconvert writes it from a map: it gets traffic from SUMO's own generators."""

import hashlib
import random
import re
import shutil
import tempfile
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree as ET

import numpy as np

from roadmend.core.bounded_file import opened_unpacked
from roadmend.core.bounds import NETWORK
from roadmend.core.errors import InputError, SimulationError
from roadmend.core.resources import cache_folder
from roadmend.core.whole_file import write_texts
from roadmend.world.procedural_traffic import DRIVERS, Demand, random_traffic, sumocfg_text
from roadmend.world.road_network import RoadNetwork, read_network

SUFFIXES = (".net.xml", ".net.xml.gz")

_VERSION = "2"  # raise when the same network shall get other traffic
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)  # SUMO writes when, where and by what a network was made
_DENSITY = 40.0  # [1/(h km)] cars that depart an hour and kilometre of road, in a network of any usual size
_MOST = 6000.0  # [1/h] departures in one so large that SUMO would be slow
_WALKERS = 12.0  # [1/(h km)] where there are sidewalks
_SHORTEST = 300.0  # [m] between begin and end of a trip, at least; less in a network that is small
_SHARE = 0.25  # of its extent


def with_traffic(path: Path) -> Path:
    """The configuration for what the user names: a lone network gets one with traffic, anything else is returned as it is.

    The traffic depends on what the network's file says alone, packed or not and wherever it lies, and is kept in the cache.

    Raises:
        InputError: the network cannot be read, no car finds a trip on it, or the cache cannot be written.
    """
    if not path.name.endswith(SUFFIXES) or not path.is_file():
        return path
    network = read_network(path)
    place = path.resolve()
    with opened_unpacked(path, NETWORK, "give a SUMO .net.xml file") as file:
        content = hashlib.sha256(_COMMENT.sub(b"", file.read())).hexdigest()
    seed = _digest(_VERSION, version("eclipse-sumo"), content)
    key = _digest(seed, str(place))  # the configuration names the network's place
    name = path.name[: path.name.index(".net.xml")] or "network"
    target = cache_folder() / "traffic" / key[:32] / name / f"{name}.sumocfg"
    if not target.exists():
        # The routes first: where the configuration stands, the rest does.
        write_texts(target.parent, {f"{name}.rou.xml": _routes(network, place, seed)})
        write_texts(target.parent, {target.name: sumocfg_text(str(place), f"{name}.rou.xml", 0)})
    return target


def _digest(*words: str) -> str:
    return hashlib.sha256("\0".join(words).encode()).hexdigest()


def _routes(network: RoadNetwork, path: Path, seed: str) -> str:
    """Cars, and people on foot where they have sidewalks."""
    lengths = [max(lane.length for lane in road.car_lanes) for road in network.roads if road.car_lanes]
    kilometres = sum(lengths) / 1000.0
    density = min(_DENSITY, _MOST / kilometres)
    least = min(_SHORTEST, _SHARE * _extent(network))
    demands = [Demand("car", DRIVERS, (density, density), reach=(least, 0.0))]
    if any(lane.for_pedestrians_only for road in network.roads for lane in road.lanes):
        walkers = min(_WALKERS, density)
        demands.append(Demand("walker", {}, (walkers, walkers), fringe=1.0, reach=(0.5 * least, 500.0)))
    with tempfile.TemporaryDirectory(prefix="roadmend-") as work:
        copy = Path(work) / path.name
        shutil.copyfile(path, copy)
        try:
            routes = random_traffic(copy, demands, random.Random(f"roadmend/lone/{seed}"), Path(work))
        except SimulationError as error:
            mend = "mend the network, or give a .sumocfg with traffic of your own"
            raise InputError(str(path), f"gets no traffic ({error})", mend) from None
    if ET.fromstring(routes).find("vehicle") is None:
        mend = "give it roads that lead somewhere, or a .sumocfg with traffic of your own"
        raise InputError(str(path), "has no way for cars between two of its roads", mend)
    return routes


def _extent(network: RoadNetwork) -> float:
    """The diagonal [m] of what the roads for cars cover."""
    points = np.concatenate([lane.shape for road in network.roads for lane in road.car_lanes])
    return float(np.hypot(*(points.max(axis=0) - points.min(axis=0))))
