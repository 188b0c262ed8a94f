"""A user's SUMO configuration, made fit to run here: same input, none of its output."""

from pathlib import Path
from xml.etree import ElementTree as ET

from roadmend.core.errors import InputError

_INPUT_FILES = frozenset({"net-file", "route-files", "additional-files", "weight-files", "taz-files", "load-state"})
_DROPPED = ("output", "report", "gui_only", "gui-only")  # sections whose effects belong to the user's own runs

_DEPTH = 64  # no folder lies deeper; to climb beyond the root is harmless


def read_configuration(path: Path) -> ET.Element:
    """The root element of a .sumocfg.

    Raises:
        InputError: the file is missing or is no XML.
    """
    if not path.is_file():
        raise InputError(str(path), "no such file", "give the path of a SUMO .sumocfg file")
    try:
        return ET.parse(path).getroot()
    except ET.ParseError as error:
        raise InputError(str(path), f"broken XML ({error})", "mend the SUMO configuration") from None


def network_of(path: Path) -> Path:
    """The network that a configuration names.

    Raises:
        InputError: it names none, or one that does not exist.
    """
    element = read_configuration(path).find(".//net-file")
    value = "" if element is None else element.get("value", element.get("v", ""))
    if not value:
        raise InputError(str(path), "names no net-file", "add <net-file value=.../> to its <input>")
    network = path.parent / value
    if not network.is_file():
        raise InputError(str(path), f"net-file {value} does not exist", "mend the path in the configuration")
    return network


def private_copy(path: Path, folder: Path) -> list[str]:
    """SUMO arguments that run a configuration without writing next to it.

    The copy in ``folder`` has absolute input paths and no output sections. Detectors in additional files still name
    output files, relative to their own place, which may be any folder; SUMO puts the prefix before the file's name,
    and this one climbs to the root from wherever that is and leads into ``folder``.

    Raises:
        InputError: the configuration cannot be read or names files that do not exist.
    """
    root = read_configuration(path)
    for element in list(root):
        if element.tag in _DROPPED:
            root.remove(element)
    for element in root.iter():
        if element.tag in _INPUT_FILES:
            key = "value" if "value" in element.attrib else "v"
            names = [name.strip() for name in element.get(key, "").split(",") if name.strip()]
            for name in names:
                if not (path.parent / name).is_file():
                    raise InputError(
                        str(path), f"{element.tag} {name} does not exist", "mend the path in the configuration"
                    )
            element.set(key, ",".join(str((path.parent / name).resolve()) for name in names))
    copy = folder / "user.sumocfg"
    ET.ElementTree(root).write(copy, encoding="unicode")
    prefix = "../" * _DEPTH + str(folder.resolve()).lstrip("/") + "/out-"
    return ["-c", str(copy), "--output-prefix", prefix]
