"""What is fuzzed: every reader of files from outside, as a function of a path, and small files that it reads."""

import gzip
import json
import sys
import tempfile
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.recording.errors import RecordingError

ROOT = Path(__file__).parents[2]
CORPUS = Path(__file__).parent / "corpus"
DOCUMENTED = (InputError, RecordingError)  # what a reader may raise; anything else is a fault


@dataclass(frozen=True)
class Reader:
    ending: str  # of the files it is given
    read: Callable[[Path], object]
    seeds: Callable[[], list[bytes]]
    renewed: Callable[[bytes], bytes] | None = None  # a changed file with what vouches for its content made anew


def _yaml(path):
    from roadmend.core.yaml_file import read_yaml

    return read_yaml(path)


def _json(path):
    from roadmend.core.json_text import read_json

    return read_json(path)


def _xml(path):
    from roadmend.core.xml_file import read_xml

    return read_xml(path, "mend it")


def _scenario(path):
    from roadmend.world.scenario_file import load_scenario

    return load_scenario(path)


def _network(path):
    from roadmend.world.road_network import read_network

    return read_network(path)


def _configuration(path):
    from roadmend.world.user_configuration import read_configuration

    return read_configuration(path)


def _corpus(path):
    from roadmend.world.corpus import load_corpus

    return load_corpus(path)


def _model(path):
    from roadmend.repair.adreft.model import AdreftModel

    return AdreftModel.load(path)


def _crash(path):
    from roadmend.safe.dsl_file import load_crash_scenario

    return load_crash_scenario(path)


def _report(path):
    from roadmend.safe.report import load_report

    return load_report(path)


def _sketch(path):
    from roadmend.safe.report import load_report
    from roadmend.safe.sketch.picture import open_picture

    sketch = load_report(path.parent).sketch
    return sketch and open_picture(sketch)


def _export(path):
    from roadmend.sera.exchange import read_export

    return [*read_export(path)]


def _bank(path):
    from roadmend.sera.bank import Bank

    with Bank(path) as bank:
        return [*bank.entries()]


def _exchanges(path):
    from roadmend.language.exchange import load_exchanges

    return load_exchanges(path)


def _bag(path):
    from roadmend.recording.reader import BagReader

    reader = BagReader(path)
    return reader.attachments, [message.time_ns for message in reader.messages()]


def _recovery(path):
    from roadmend.recording.info import bag_info
    from roadmend.recording.recovery import recover

    with tempfile.TemporaryDirectory() as folder:
        return bag_info(path), recover(path, Path(folder) / "out")


def _metadata(path):
    from roadmend.recording import layout

    return layout.files_of(path)


def _texts(*names):
    return lambda: [(ROOT / name).read_bytes() for name in names]


def _sample_bag():
    from roadmend.recording.writer import BagOptions, BagWriter

    with tempfile.TemporaryDirectory() as folder:
        with BagWriter(Path(folder) / "bag", BagOptions(chunk_size=200)) as writer:
            writer.add_topic("/clock", "rosgraph_msgs/msg/Clock")
            for number in range(20):
                writer.write("/clock", number * 1000, b"\0\1\0\0" + number.to_bytes(8, "little"))
            writer.add_attachment("scenario.yaml", "application/yaml", b"name: x\n")
            writer.add_metadata("roadmend", {"seed": "7"})
        return [path.read_bytes() for path in sorted(Path(folder).glob("bag/*.mcap"))]


def _sample_metadata():
    from roadmend.recording import layout

    return [layout.as_text({"rosbag2_bagfile_information": layout.bag_information([], [])}).encode()]


def _sample_bank():
    from roadmend.sera.bank import build_bank
    from roadmend.sera.describe import entry_of
    from roadmend.world.families import sample_scenario

    with tempfile.TemporaryDirectory() as folder:
        build_bank(Path(folder) / "a.bank", [entry_of(sample_scenario("S3", seed), "made") for seed in range(3)])
        return [(Path(folder) / "a.bank").read_bytes()]


def _sample_export():
    from roadmend.sera.bank import Bank
    from roadmend.sera.exchange import export_bank

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "a.bank").write_bytes(_sample_bank()[0])
        with Bank(Path(folder) / "a.bank") as bank:
            export_bank(bank, Path(folder) / "a.jsonl")
        return [(Path(folder) / "a.jsonl").read_bytes()]


def _sample_corpus():
    lines = (ROOT / "config/corpora/modular.jsonl").read_bytes().splitlines(keepends=True)
    header = json.loads(lines[0]) | {"cases": 3}
    return [json.dumps(header).encode() + b"\n" + b"".join(lines[1:4])]


def _sample_model():
    """Tiny ones: the shipped ones are larger than a changed file may be, so that cut they were all refused at once."""
    if str(ROOT) not in sys.path:
        sys.path.append(str(ROOT))
    from tests.repair.tiny_model import RISK, save_tiny_model

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.safetensors"
        return [save_tiny_model(path, **changes).read_bytes() for changes in ({}, {"need": RISK, "change": RISK})]


def _renewed_model(data):
    """With the length of the head, the size of the tensors and the checksum that its content has, where it has any.

    Without it nearly every change would be refused for one of these, and what lies behind them be given nothing.
    """
    import safetensors.numpy

    from roadmend.networks import checkpoint

    try:
        text = data[8:].decode("latin-1")
        head, length = json.JSONDecoder().raw_decode(text)
        sizes = [each["data_offsets"][1] for name, each in head.items() if name != "__metadata__"]
        tensors = data[8 + length :].lstrip(b" ")[: max(sizes)].ljust(max(sizes), b"\0")
        plain = json.dumps(head).encode()
        arrays = safetensors.numpy.load(len(plain).to_bytes(8, "little") + plain + tensors)
        header = json.loads(head["__metadata__"]["roadmend"])
        header.pop("checksum", None)
        header["checksum"] = checkpoint._checksum(header, arrays)
        return safetensors.numpy.save(arrays, {"roadmend": checkpoint._canonical(header)})
    except Exception:  # noqa: BLE001 - it is no model file any more, and is given as it is
        return data


def _sample_sketch():
    import io

    import PIL.Image

    found = []
    for form in ("PNG", "JPEG", "GIF", "WEBP", "BMP", "TIFF"):
        data = io.BytesIO()
        PIL.Image.new("RGB", (20, 20), (9, 99, 199)).save(data, form)
        found.append(data.getvalue())
    return found


_YAMLS = _texts("tests/golden/town.yaml", "tests/golden/crash-report.yaml")
_XMLS = _texts("tests/golden/town/town.sumocfg", "tests/golden/town/town.net.xml")
READERS = {
    "yaml": Reader(".yaml", _yaml, lambda: [*_YAMLS(), b"a: &a [1, 0x2, 1:30, 2026-01-01]\nb: {<<: {x: 1}, y: *a}\n"]),
    "json": Reader(".json", _json, lambda: [b'{"a": [1, 2.5e3, true, null, "\\u00e4"], "b": {"c": []}}']),
    "xml": Reader(".xml", _xml, lambda: [*_XMLS(), gzip.compress(_XMLS()[0])]),
    "scenario": Reader(".yaml", _scenario, _YAMLS),
    "network": Reader(".net.xml", _network, _texts("tests/golden/town/town.net.xml")),
    "configuration": Reader(".sumocfg", _configuration, _XMLS),
    "corpus": Reader(".jsonl", _corpus, _sample_corpus),
    "model": Reader(".safetensors", _model, _sample_model, _renewed_model),
    "crash-json": Reader(".json", _crash, lambda: [_crash_seed(".json")]),
    "crash-yaml": Reader(".yaml", _crash, lambda: [_crash_seed(".yaml")]),
    "crash-text": Reader(".dsl", _crash, lambda: [_crash_seed(".dsl")]),
    "report": Reader(".txt", _report, lambda: [b"Vehicle 1 was travelling north.\n", "\ufeffVehicle \u00e4".encode()]),
    "sketch": Reader(".png", _sketch, _sample_sketch),
    "export": Reader(".jsonl", _export, _sample_export),
    "bank": Reader(".bank", _bank, _sample_bank),
    "exchanges": Reader(
        ".jsonl", _exchanges, lambda: [b'{"digest": "a", "request": {}, "reply": null, "error": "x"}\n']
    ),
    "bag": Reader(".mcap", _bag, _sample_bag),
    "recovery": Reader(".mcap", _recovery, _sample_bag),
    "metadata": Reader(".yaml", _metadata, _sample_metadata),
}


def _crash_seed(ending):
    from roadmend.safe.dsl_file import dump_crash_scenario, parse_crash_scenario

    text = (ROOT / "tests/fuzz/corpus/crash.dsl").read_text(encoding="utf-8")
    return dump_crash_scenario(parse_crash_scenario(text, ".dsl", "seed"), ending).encode()


def seeds_of(name: str) -> list[bytes]:
    """Files that a reader reads, those that once broke one, and those that reach code that others do not."""
    broke = [path.read_bytes() for path in sorted(CORPUS.glob(f"{name}-*"))]
    return [*READERS[name].seeds(), *broke, *kept_of(name)]


def kept_of(name: str) -> list[bytes]:
    """Files that reach code that others do not, as ``fuzz/run.py --engine atheris --keep`` has left them."""
    kept = CORPUS / f"{name}.zip"
    if not kept.exists():
        return []
    with zipfile.ZipFile(kept) as archive:
        return [archive.read(each) for each in archive.namelist()]


def place_of(name: str, folder: Path) -> Path:
    """Where a reader's file lies in a folder; some readers want another file beside it."""
    if name == "metadata":
        return folder / "metadata.yaml"
    if name == "sketch":
        (folder / "summary.txt").write_text("Vehicle 1 was travelling north.")
        return folder / "sketch.png"
    return folder / f"file{READERS[name].ending}"
