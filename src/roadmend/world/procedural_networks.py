"""Procedurally generated SUMO configurations: roads and traffic of four kinds, by SUMO's own generators.

They stand for configurations of other making: nothing in them is built as the scenario families build theirs.
"""

import os
import random
import re
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

from roadmend.core.errors import SimulationError
from roadmend.core.whole_file import write_texts
from roadmend.world.network import find_binary, netconvert
from roadmend.world.procedural_roads import describe_motorway, describe_rural

FIRST_TRAINING_SEED = 10_000  # seeds below are for tests of methods, seeds from here on for training
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
class _Demand:
    """One sort of traffic."""

    prefix: str
    mix: Mapping[str, float]  # shares of the types; none: people on foot
    density: tuple[float, float]  # [1/(h km)] departures an hour and kilometre of road, least and most
    fringe: float = 5.0  # how much more likely a trip begins or ends at the network's edge
    reach: tuple[float, float] = (300.0, 0.0)  # [m] between begin and end, least and most; 0: no limit


_DRIVERS = {"car": 0.82, "van": 0.1, "truck": 0.05, "motorcycle": 0.03}
_DEMANDS: dict[str, tuple[_Demand, ...]] = {
    "city": (
        _Demand("car", _DRIVERS, (25.0, 60.0)),
        _Demand("bicycle", {"bicycle": 1.0}, (4.0, 14.0), fringe=1.0),
        _Demand("walker", {}, (8.0, 25.0), fringe=1.0, reach=(80.0, 500.0)),
    ),
    "ring": (_Demand("car", _DRIVERS, (60.0, 140.0)), _Demand("bicycle", {"bicycle": 1.0}, (2.0, 8.0))),
    "motorway": (
        _Demand("car", {"car": 0.72, "van": 0.1, "truck": 0.06, "trailer": 0.09, "motorcycle": 0.03}, (30.0, 110.0)),
    ),
    "rural": (_Demand("car", {"car": 0.78, "van": 0.08, "truck": 0.07, "slow": 0.07}, (30.0, 90.0)),),
}
KINDS = tuple(_DEMANDS)


class NetworkRequest(NamedTuple):
    """What shall be made, and where; travels to other processes by pickle."""

    kind: str  # one of KINDS
    seed: int  # decides roads and traffic
    parent: Path  # folder in which the folder KIND-SEED is made


def generate_configuration(request: NetworkRequest) -> Path:
    """Write a network with traffic as a folder of a .net.xml, a .rou.xml and a .sumocfg.

    The same kind and seed give the same bytes with one release of SUMO.

    Returns:
        The .sumocfg.

    Raises:
        InputError: the folder cannot be written.
        SimulationError: a generator of SUMO failed.
    """
    kind, seed, parent = request
    numbers = random.Random(f"roadmend/procedural/{kind}/{seed}")
    name = f"{kind}-{seed}"
    with tempfile.TemporaryDirectory(prefix="roadmend-") as work:
        network = _network(kind, numbers, seed, Path(work))
        routes = _traffic(network, _DEMANDS[kind], numbers, Path(work))
        texts = {
            f"{name}.net.xml": _without_comments(network),
            f"{name}.rou.xml": routes,
            f"{name}.sumocfg": _configuration(name, seed),
        }
    write_texts(parent / name, texts)
    return parent / name / f"{name}.sumocfg"


def _configuration(name: str, seed: int) -> str:
    root = ET.Element("configuration")
    given = ET.SubElement(root, "input")
    ET.SubElement(given, "net-file", value=f"{name}.net.xml")
    ET.SubElement(given, "route-files", value=f"{name}.rou.xml")
    time = ET.SubElement(root, "time")
    ET.SubElement(time, "begin", value="0")
    ET.SubElement(time, "end", value=str(DURATION))
    ET.SubElement(ET.SubElement(root, "random_number"), "seed", value=str(seed))
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _network(kind: str, numbers: random.Random, seed: int, folder: Path) -> Path:
    match kind:
        case "motorway":
            plain = describe_motorway(numbers)
        case "rural":
            plain = describe_rural(numbers)
        case _:
            options = _city(numbers) if kind == "city" else _ring(numbers)
            target = folder / "built.net.xml"
            _run([str(find_binary("netgenerate")), *options, "--seed", str(seed), "-o", target.name], folder)
            return target
    return netconvert(folder, plain.texts(), plain.options)


def _city(numbers: random.Random) -> list[str]:
    """Blocks, or streets at random, with traffic lights, sidewalks and now and then lanes for bicycles."""
    options = ["-L", str(numbers.choice((1, 1, 2))), "--default.speed", f"{numbers.choice((8.33, 13.89, 13.89)):g}"]
    if numbers.random() < 0.65:
        options += ["--grid", "--grid.x-number", str(numbers.randint(3, 5))]
        options += ["--grid.y-number", str(numbers.randint(3, 5)), "--grid.attach-length", "120"]
        options += ["--grid.x-length", f"{numbers.uniform(90, 190):.0f}"]
        options += ["--grid.y-length", f"{numbers.uniform(90, 190):.0f}"]
        options += ["--perturb-x", f"norm(0,{numbers.uniform(0, 12):.1f})"]
        options += ["--perturb-y", f"norm(0,{numbers.uniform(0, 12):.1f})"]
    else:
        options += ["--rand", "--rand.iterations", str(numbers.randint(40, 70)), "--rand.min-distance", "80"]
        options += ["--rand.max-distance", "220", "--rand.min-angle", "50"]
    if numbers.random() < 0.4:
        options += ["--default-junction-type", "traffic_light"]
    else:
        options += ["--tls.guess", "--tls.guess.threshold", f"{numbers.uniform(30, 70):.0f}"]
    if numbers.random() < 0.4:
        options += ["--random-priority"]
    if numbers.random() < 0.3:
        options += ["--turn-lanes", "1", "--turn-lanes.length", "30"]
    if numbers.random() < 0.75:
        options += ["--bikelanes.guess"]
    return [*options, "--sidewalks.guess", "--crossings.guess", "--no-turnarounds"]


def _ring(numbers: random.Random) -> list[str]:
    """Ring roads, one around the other, with arms across them."""
    options = ["--spider", "--spider.arm-number", str(numbers.randint(5, 8))]
    options += ["--spider.circle-number", str(numbers.randint(2, 3)), "--spider.attach-length", "150"]
    options += ["--spider.space-radius", f"{numbers.uniform(110, 200):.0f}", "-L", str(numbers.choice((1, 1, 2)))]
    if numbers.random() < 0.6:
        options += ["--spider.omit-center"]
    if numbers.random() < 0.35:
        options += ["--default-junction-type", numbers.choice(("traffic_light", "right_before_left"))]
    else:
        options += ["--random-priority"]
    return [*options, "--default.speed", f"{numbers.choice((11.11, 13.89, 16.67)):g}", "--no-turnarounds"]


def _traffic(network: Path, demands: Sequence[_Demand], numbers: random.Random, folder: Path) -> str:
    """The routes of everybody, by the time of departure, as one document."""
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


def _trips(network: Path, demand: _Demand, numbers: random.Random, folder: Path) -> list[ET.Element]:
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
    _run(command, folder)
    found = [one for one in ET.parse(target).getroot() if one.tag in {"vehicle", "person"}]
    for one in found:
        if demand.mix:
            one.set("type", numbers.choices([*demand.mix], [*demand.mix.values()])[0])
            one.set("departLane", "best")
            one.set("departSpeed", "max")
    return found


def _run(command: Sequence[str], folder: Path) -> None:
    environment = {**os.environ, "SUMO_HOME": str(find_binary("netgenerate").parent.parent)}
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, env=environment)
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if "Error:" in line] or ["no reason given"]
        raise SimulationError(f"{Path(command[0]).name} failed: {said[0].partition('Error:')[2].strip() or said[0]}")


def _without_comments(path: Path) -> str:
    """A document of SUMO's without the time and the place at which it was made."""
    text = path.read_text(encoding="utf-8")
    return re.sub(r"<!--.*?-->\s*", "", text, flags=re.DOTALL)
