"""Traffic by SUMO's own generators, for a network of anybody's: trips at random, and the .sumocfg that joins the two."""

import os
import random
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree as ET

from roadmend.core.errors import SimulationError
from roadmend.world.network import find_binary

DURATION = 1800  # [s] of traffic

_CAR = {"vClass": "passenger", "speedDev": "0.1"}
_TYPES: dict[str, dict[str, str]] = {
    "car": _CAR,
    "van": {"vClass": "delivery", "length": "6.5", "width": "2.1", "accel": "2.0", "speedDev": "0.1"},
    "truck": {"vClass": "truck", "length": "10", "accel": "1.2", "maxSpeed": "25"},
    "trailer": {"vClass": "trailer", "length": "16.5", "accel": "0.9", "maxSpeed": "23"},
    "motorcycle": {"vClass": "motorcycle", "accel": "4.0"},
    "bicycle": {"vClass": "bicycle", "maxSpeed": "5.5"},
    "slow": {**_CAR, "maxSpeed": "12", "sigma": "0.8"},
}


@dataclass(frozen=True, slots=True)
class Demand:
    """One sort of traffic."""

    prefix: str
    mix: Mapping[str, float]  # shares of the types; none: people on foot
    density: tuple[float, float]  # [1/(h km)] departures an hour and kilometre of road, least and most
    fringe: float = 5.0  # how much more likely a trip begins or ends at the network's edge
    reach: tuple[float, float] = (300.0, 0.0)  # [m] between begin and end, least and most; 0: no limit


DRIVERS = {"car": 0.82, "van": 0.1, "truck": 0.05, "motorcycle": 0.03}


def sumocfg_text(network: str, routes: str, seed: int) -> str:
    """A configuration that drives the routes on the network for ``DURATION``; the files as they are seen from its own."""
    root = ET.Element("configuration")
    given = ET.SubElement(root, "input")
    ET.SubElement(given, "net-file", value=network)
    ET.SubElement(given, "route-files", value=routes)
    time = ET.SubElement(root, "time")
    ET.SubElement(time, "begin", value="0")
    ET.SubElement(time, "end", value=str(DURATION))
    ET.SubElement(ET.SubElement(root, "random_number"), "seed", value=str(seed))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def random_traffic(network: Path, demands: Sequence[Demand], numbers: random.Random, folder: Path) -> str:
    """The routes of everybody, by the time of departure, as one document.

    Args:
        network: in ``folder``.
        demands: sorts of traffic.
        numbers: that draw how dense each is, and its trips.
        folder: to work in; what is left there is nobody's.

    Raises:
        SimulationError: a generator of SUMO failed.
    """
    root = ET.Element("routes")
    travellers: list[ET.Element] = []
    for kind in dict.fromkeys(each for demand in demands for each in demand.mix):
        ET.SubElement(root, "vType", {"id": kind, **_TYPES[kind]})
    for demand in demands:
        travellers += _trips(network, demand, numbers, folder)
    travellers.sort(key=lambda one: (float(one.attrib["depart"]), one.attrib["id"]))
    root.extend(travellers)
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _trips(network: Path, demand: Demand, numbers: random.Random, folder: Path) -> list[ET.Element]:
    target = folder / f"{demand.prefix}.rou.xml"
    vehicle_class = "bicycle" if demand.prefix == "bicycle" else "passenger"
    command = [sys.executable, str(find_binary("netgenerate").parent.parent / "tools" / "randomTrips.py")]
    command += ["-n", network.name, "-o", f"{demand.prefix}.trips.xml", "-r", target.name, "--validate"]
    command += ["--prefix", demand.prefix, "--begin", "0", "--end", str(DURATION), "--random-depart"]
    command += ["--insertion-density", f"{numbers.uniform(*demand.density):.2f}"]
    command += ["--fringe-factor", f"{demand.fringe:g}", "--seed", str(numbers.randrange(2**30))]
    least, most = demand.reach
    command += ["--min-distance", f"{least:g}", *(["--max-distance", f"{most:g}"] if most else [])]
    if demand.mix:
        command += ["--vehicle-class", vehicle_class, "--remove-loops", "--random-routing-factor", "1.5"]
    else:
        command += ["--pedestrians"]
    run_tool(command, folder)
    found = [one for one in ET.parse(target).getroot() if one.tag in {"vehicle", "person"}]
    for one in found:
        if demand.mix:
            one.set("type", numbers.choices([*demand.mix], [*demand.mix.values()])[0])
            one.set("departLane", "best")
            one.set("departSpeed", "max")
    return found


def run_tool(command: Sequence[str], folder: Path) -> None:
    """Run a program of SUMO in a folder.

    Raises:
        SimulationError: it failed, with what it says of it.
    """
    environment = {**os.environ, "SUMO_HOME": str(find_binary("netgenerate").parent.parent)}
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=environment)
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if "Error:" in line] or ["no reason given"]
        tool = next(Path(word).name for word in command if word != sys.executable)
        raise SimulationError(f"{tool} failed: {said[0].partition('Error:')[2].strip() or said[0]}")
