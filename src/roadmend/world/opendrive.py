"""Road networks as ASAM OpenDRIVE: netconvert writes the file and reads it back."""

import subprocess
import tempfile
from pathlib import Path
from xml.etree import ElementTree as ET

from roadmend.core.errors import InputError, SimulationError
from roadmend.world.network import find_binary
from roadmend.world.opendrive_conform import conform


def write_opendrive(network: Path, target: Path) -> None:
    """Write a SUMO network as OpenDRIVE (revision 1.7), complete or not at all.

    The result is in the form that other readers ask for, and is read back by netconvert before it is put into place.

    Args:
        network: the .net.xml file.
        target: the .xodr file.

    Raises:
        InputError: the place cannot be written.
        SimulationError: netconvert cannot write the network, or cannot read what it wrote.
    """
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=target.parent, prefix=".") as folder:
            beside = Path(folder) / target.name
            _netconvert("--sumo-net-file", str(network.resolve()), "--opendrive-output", str(beside))
            tree = ET.parse(beside)  # our own file; a comment in it, with paths of this machine, is not taken over
            conform(tree.getroot())
            tree.write(beside, encoding="UTF-8", xml_declaration=True)
            _netconvert("--opendrive-files", str(beside), "--output-file", str(Path(folder) / "back.net.xml"))
            beside.replace(target)
    except OSError as error:
        raise InputError(str(target), f"cannot be written ({error.strerror})", "choose a writable folder") from None


def _netconvert(*arguments: str) -> None:
    command = [str(find_binary("netconvert")), *arguments, "--no-warnings", "true"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        lines = [line for line in done.stderr.splitlines() if line.strip()]
        raise SimulationError(f"netconvert failed: {lines[0] if lines else 'no reason given'}")
