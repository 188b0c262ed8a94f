"""Procedurally generated SUMO configurations: roads and traffic of four kinds, by SUMO's own generators.

They stand for configurations of other making: nothing in them is built as the scenario families build theirs.
"""

import random
import re
import tempfile
from pathlib import Path
from typing import NamedTuple

from roadmend.core.whole_file import write_texts
from roadmend.world.network import find_binary, netconvert
from roadmend.world.procedural_roads import describe_motorway, describe_rural
from roadmend.world.procedural_traffic import DRIVERS, Demand, random_traffic, run_tool, sumocfg_text

FIRST_TRAINING_SEED = 10_000  # seeds below are for tests of methods, seeds from here on for training

_DEMANDS: dict[str, tuple[Demand, ...]] = {
    "city": (
        Demand("car", DRIVERS, (25.0, 60.0)),
        Demand("bicycle", {"bicycle": 1.0}, (4.0, 14.0), fringe=1.0),
        Demand("walker", {}, (8.0, 25.0), fringe=1.0, reach=(80.0, 500.0)),
    ),
    "ring": (Demand("car", DRIVERS, (60.0, 140.0)), Demand("bicycle", {"bicycle": 1.0}, (2.0, 8.0))),
    "motorway": (
        Demand("car", {"car": 0.72, "van": 0.1, "truck": 0.06, "trailer": 0.09, "motorcycle": 0.03}, (30.0, 110.0)),
    ),
    "rural": (Demand("car", {"car": 0.78, "van": 0.08, "truck": 0.07, "slow": 0.07}, (30.0, 90.0)),),
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
        routes = random_traffic(network, _DEMANDS[kind], numbers, Path(work))
        texts = {
            f"{name}.net.xml": _without_comments(network),
            f"{name}.rou.xml": routes,
            f"{name}.sumocfg": sumocfg_text(f"{name}.net.xml", f"{name}.rou.xml", seed),
        }
    write_texts(parent / name, texts)
    return parent / name / f"{name}.sumocfg"


def _network(kind: str, numbers: random.Random, seed: int, folder: Path) -> Path:
    match kind:
        case "motorway":
            plain = describe_motorway(numbers)
        case "rural":
            plain = describe_rural(numbers)
        case _:
            options = _city(numbers) if kind == "city" else _ring(numbers)
            target = folder / "built.net.xml"
            run_tool([str(find_binary("netgenerate")), *options, "--seed", str(seed), "-o", target.name], folder)
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


def _without_comments(path: Path) -> str:
    """A document of SUMO's without the time and the place at which it was made."""
    text = path.read_text(encoding="utf-8")
    return re.sub(r"<!--.*?-->\s*", "", text, flags=re.DOTALL)
