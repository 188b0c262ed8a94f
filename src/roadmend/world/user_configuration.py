"""A user's SUMO configuration, made fit to run here: same input, none of its output, and no will of its own."""

import hashlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

from roadmend.core.errors import InputError
from roadmend.core.xml_file import read_xml

_NET = frozenset({"net-file", "net", "n"})
_INPUT_FILES = _NET | {
    "route-files",
    "routes",
    "r",
    "additional-files",
    "additional",
    "a",
    "weight-files",
    "weights",
    "w",
    "taz-files",
    "load-state",
    "astar.all-distances",
    "astar.landmark-distances",
    "device.fcd-replay.files",
}
WANTED = "give the path of a SUMO configuration (.sumocfg) or network (.net.xml, .net.xml.gz)"
# Sections whose effects belong to the user's own runs.
_DROPPED = ("output", "report", "gui_only", "gui-only")
# So do these options, in whatever section: they write, wait for a client, open windows, or draw numbers and share work
# in a way that makes every run another.
_OTHERS = frozenset(
    {
        "alternative-net-file",
        "breakpoints",
        "device.rerouting.threads",
        "edgedata-files",
        "end",
        "error-log",
        "gui-settings-file",
        "log",
        "log-file",
        "message-log",
        "netstate",
        "netstate-dump",
        "ndump",
        "num-clients",
        "random",
        "remote-port",
        "save-configuration",
        "save-schema",
        "save-template",
        "selection-file",
        "summary",
        "threads",
        "tripinfo",
        "vehroutes",
    }
)
_WRITING_PREFIXES = ("output", "save-state.", "fcd-output.", "pedestrian.jupedsim.")
_WRITING_SUFFIXES = ("-output", ".output", "ssm.file", "toc.file")
# These take away who stands for long on a fast road or in a wrong lane: the ego too, which is ours to move.
_TELEPORTING = "time-to-teleport."

_DEPTH = 64  # no folder lies deeper; to climb beyond the root is harmless


def read_configuration(path: Path) -> ET.Element:
    """The root element of a .sumocfg.

    Raises:
        InputError: the file is missing, is no XML, or no configuration for the microscopic simulation.
    """
    if not path.is_file():
        raise InputError(str(path), "no such file", WANTED)
    root = read_xml(path, "mend the SUMO configuration")
    if root.tag in {"net", "routes", "additional"}:
        raise InputError(str(path), f"is no SUMO configuration (its root is <{root.tag}>)", "give a .sumocfg file")
    for option in root.iter("mesosim"):
        if _value(option).lower() in {"true", "1", "yes", "on", "x", "t"}:
            raise InputError(str(path), "simulates queues and not vehicles (mesosim)", "take mesosim out of it")
    return root


def network_of(path: Path) -> Path:
    """The network that a configuration names.

    Raises:
        InputError: it names none, or one that does not exist.
    """
    found = [option for option in read_configuration(path).iter() if option.tag in _NET and _value(option)]
    if not found:
        raise InputError(str(path), "names no net-file", "add <net-file value=.../> to its <input>")
    return _existing(path, "net-file", _value(found[0]))


def private_copy(path: Path, folder: Path) -> list[str]:
    """SUMO arguments that run a configuration without writing next to it.

    The copy in ``folder`` has absolute input paths and no output. Detectors in additional files still name
    output files, relative to their own place, which may be any folder; SUMO puts the prefix before the file's name,
    and this one climbs to the root from wherever that is and leads into ``folder``.

    Raises:
        InputError: the configuration cannot be read or names files that do not exist.
    """
    root = read_configuration(path)
    for parent in list(root.iter()):
        for element in list(parent):
            if _is_dropped(element, at_root=parent is root):
                parent.remove(element)
    for element in root.iter():
        if element.tag in _INPUT_FILES:
            option = "net-file" if element.tag in _NET else element.tag
            paths = [str(_existing(path, option, name)) for name in _names(_value(element))]
            element.attrib.clear()
            element.text = None
            element.set("value", ",".join(paths))
    copy = folder / "user.sumocfg"
    ET.ElementTree(root).write(copy, encoding="unicode")
    prefix = "../" * _DEPTH + str(folder.resolve()).lstrip("/") + "/out-"
    return ["-c", str(copy), "--output-prefix", prefix]


def content_of(path: Path) -> str:
    """SHA-256 of a configuration and of the files that it names, hexadecimal.

    Raises:
        InputError: the configuration cannot be read or names files that do not exist.
    """
    digest = hashlib.sha256(path.read_bytes())
    for option in read_configuration(path).iter():
        if option.tag in _INPUT_FILES:
            for name in _names(_value(option)):
                digest.update(_existing(path, option.tag, name).read_bytes())
    return digest.hexdigest()


def configurations_in(paths: Sequence[Path]) -> Iterator[tuple[str, Path]]:
    """The configurations among files and, in folders, all that lie below; each with a name of its own.

    Raises:
        InputError: a path does not exist, or there is no configuration in a folder.
    """
    for given in paths:
        found = sorted(given.rglob("*.sumocfg")) if given.is_dir() else [given]
        if not found:
            raise InputError(str(given), "holds no .sumocfg", "'roadmend networks' makes some")
        for path in found:
            if not path.is_file():
                raise InputError(str(path), "no such file", f"{WANTED}, or of a folder")
            # What is a link in a folder goes by its place there, wherever it leads.
            place = given.resolve() / path.relative_to(given) if given.is_dir() else path.resolve()
            top = given.resolve().parent if given.is_dir() else place.parent.parent
            parts = place.relative_to(top).with_suffix("").parts
            yield "-".join(part for part, after in zip(parts, (*parts[1:], ""), strict=True) if part != after), path


def _existing(path: Path, option: str, value: str) -> Path:
    """A file that a configuration names, which may use variables of the environment as SUMO does."""
    found = (path.parent / os.path.expandvars(value.strip())).resolve()
    if not found.is_file():
        raise InputError(str(path), f"{option} {value.strip()} does not exist", "mend the path in the configuration")
    return found


def _names(value: str) -> list[str]:
    return [name for name in value.split(",") if name.strip()]


def _value(option: ET.Element) -> str:
    return (option.get("value") or option.get("v") or option.text or "").strip()


def _is_dropped(element: ET.Element, *, at_root: bool) -> bool:
    """Whether a section or an option is none of ours."""
    name = element.tag.lower()
    if at_root and name in _DROPPED:
        return True
    return name in _OTHERS or name.startswith((*_WRITING_PREFIXES, _TELEPORTING)) or name.endswith(_WRITING_SUFFIXES)
