"""The kinds of files that commands read: a sound one of each, and a command that reads it."""

from collections.abc import Sequence
from dataclasses import dataclass

SCENARIO = "scenario.yaml"
VARIED = ("truncated", "flipped")  # damages that may leave a file that says something, and is then read


@dataclass(frozen=True)
class FileKind:
    """A kind of file: a sound one, and a command that reads it.

    Attributes:
        name: of the file.
        read: words of the command; {file} is the file, {out} a place for results, {scenario} a sound scenario.
        copied: place of a sound file in the folder config; empty where it is made.
        made: words of the commands that make one at {file}, or in a folder {made}.
        at: where in {made} it then lies.
        beside: places in {made} of sound files that it names, which lie beside it under their own names.
        exits: codes of a refusal: commands that read many files end with 1 where they could not read one.
        may_pass: damages after which it may be read all the same.
    """

    name: str
    read: Sequence[str]
    copied: str = ""
    made: Sequence[Sequence[str]] = ()
    at: str = ""
    beside: Sequence[str] = ()
    exits: tuple[int, ...] = (2,)
    may_pass: tuple[str, ...] = VARIED


_RUN = ("run", "--scenario", "{scenario}", "--repair", "none", "--no-viz", "--name", "bag", "--out", "{made}")
_NETWORK = (("networks", "--kind", "ring", "--count", "1", "--out", "{made}"),)
_BANK = ("sera", "bank", "build", "--sample", "2", "--out", "{made}/a.bank")
_DRIVE = ("evaluate", "{scenario}", "--out", "{out}")
_SAFE = (("safe", "extract", "{report}", "--out", "{made}"),)
FILES = {
    "scenario": FileKind("f.yaml", ("evaluate", "{file}", "--out", "{out}"), made=((),)),
    "SUMO network": FileKind(
        "f.net.xml",
        ("evaluate", "--sumocfg", "{file}", "--egos", "1", "--time-limit", "3", "--out", "{out}"),
        made=_NETWORK,
        at="ring-0/ring-0.net.xml",
    ),
    "SUMO configuration": FileKind(
        "f.sumocfg",
        ("evaluate", "--sumocfg", "{file}", "--egos", "1", "--time-limit", "3", "--out", "{out}"),
        made=_NETWORK,
        at="ring-0/ring-0.sumocfg",
        beside=("ring-0/ring-0.net.xml", "ring-0/ring-0.rou.xml"),
    ),
    "repair model": FileKind(
        "f.safetensors", (*_DRIVE, "--repair", "{file}"), copied="models/adreft-modular.safetensors", may_pass=()
    ),
    "policy model": FileKind(
        "f.safetensors", (*_DRIVE, "--policy", "{file}"), copied="models/ego_mlp.safetensors", may_pass=()
    ),
    "corpus": FileKind("f.jsonl", ("corpus", "show", "--corpus", "{file}"), copied="corpora/modular.jsonl"),
    "search settings": FileKind(
        "f.yaml",
        (
            "search",
            "--family",
            "S3",
            "--technique",
            "avfuzzer",
            "--budget",
            "1",
            "--parameters",
            "{file}",
            "--out",
            "{out}",
        ),
        copied="search/avfuzzer.yaml",
    ),
    "ROS parameters": FileKind(
        "f.yaml",
        (*_RUN[:6], "--no-record", "--ros-args", "--params-file", "{file}"),
        copied="graph.yaml",
    ),
    "crash report": FileKind(
        "f.txt",
        ("safe", "extract", "{file}", "--out", "{out}"),
        copied="reports/straight/summary.txt",
        exits=(1, 2),
        may_pass=(*VARIED, "deep"),
    ),
    "crash scenario": FileKind(
        "f.json",
        ("safe", "build", "{file}", "--samples", "1", "--workers", "1", "--out", "{out}"),
        made=_SAFE,
        at="straight.json",
    ),
    "bank": FileKind("f.bank", ("sera", "bank", "show", "--bank", "{file}"), made=(_BANK,), at="a.bank"),
    "exported bank": FileKind(
        "f.jsonl",
        ("sera", "bank", "import", "{file}", "--out", "{out}"),
        made=(_BANK, ("sera", "bank", "export", "--bank", "{made}/a.bank", "--out", "{made}/a.jsonl")),
        at="a.jsonl",
    ),
    "bag": FileKind("f.mcap", ("bag", "info", "{file}"), made=(_RUN,), at="bag/bag_0.mcap"),
    "bag to recover": FileKind(
        "f.mcap", ("bag", "recover", "{file}", "--out", "{out}"), made=(_RUN,), at="bag/bag_0.mcap"
    ),
    "bag's metadata": FileKind(
        "metadata.yaml",
        ("bag", "convert", "{file}", "--out", "{out}"),
        made=(_RUN,),
        at="bag/metadata.yaml",
        beside=("bag/bag_0.mcap",),
    ),
}
