"""Files that nobody means well with, given to every command that reads one: a line, code 2, and little memory."""

import resource

import pytest

from roadmend.cli.main import main

from .hostile import HOSTILE

MEMORY = 512 << 10  # [KiB] that one file may make this process grow by
# What 'bag info' tells of instead of refusing it: a chunk that lies is a damaged one, and the index is not looked at.
_DAMAGED = {"bag_lying", "bag_lz4", "bag_repeated"}
_OF_SEVERAL = {"report", "bag analysed"}  # commands that name each file they cannot read, and end with 1 then
# What is a text to this reader, or no fault of the file: a crash report may say anything, and an empty YAML file says
# that everything shall be as it is.
_TEXTS = {name for name in HOSTILE if name not in {"fifo", "endless", "loop", "huge", "bytes", "folder", "empty"}}
COMMANDS = {
    "scenario": (("run", "--scenario", "{}/f.yaml", "--no-record"), ()),
    "configuration": (("run", "--sumocfg", "{}/f.sumocfg", "--no-record"), ()),
    "network": (("run", "--net", "{}/f.net.xml", "--no-record"), ()),
    "packed network": (("run", "--net", "{}/f.net.xml.gz", "--no-record"), ()),
    "repair model": (("run", "--scenario", "scenario.yaml", "--repair", "{}/f.safetensors", "--no-record"), ()),
    "policy model": (("run", "--scenario", "scenario.yaml", "--policy", "{}/f.safetensors", "--no-record"), ()),
    "parameters": (("search", "--technique", "avfuzzer", "--parameters", "{}/f.yaml", "--out", "out"), ("empty",)),
    "corpus": (("corpus", "show", "--corpus", "{}/f.jsonl"), ()),
    "measured corpus": (("evaluate", "--corpus", "{}/f.jsonl", "--out", "out"), ()),
    "measured scenarios": (("evaluate", "{}/f.yaml", "--out", "out"), ()),
    "report": (("safe", "extract", "{}/f.txt", "--out", "out"), _TEXTS),
    "crash as JSON": (("safe", "export", "{}/f.json", "--out", "out"), ()),
    "crash as YAML": (("safe", "export", "{}/f.yaml", "--out", "out"), ()),
    "crash as text": (("safe", "export", "{}/f.dsl", "--out", "out"), ()),
    "export of a bank": (("sera", "bank", "import", "{}/f.jsonl", "--out", "out"), ()),
    "bank": (("sera", "bank", "show", "--bank", "{}/f.bank"), ()),
    "bag info": (("bag", "info", "{}/f.mcap"), _DAMAGED),
    "bag recover": (("bag", "recover", "{}/f.mcap", "--out", "out"), ("bag_repeated",)),
    "bag diff": (("bag", "diff", "{}/f.mcap", "{}/f.mcap"), ()),
    "bag convert": (("bag", "convert", "{}/f.mcap", "--out", "out"), ()),
    "bag analysed": (("sera", "analyse", "{}/f.mcap"), ()),
    "metadata": (("bag", "info", "{}/metadata.yaml"), _DAMAGED),
}
TRAINING = {
    "imitation": (("train", "policy", "--config", "{}/f.yaml", "--out", "out"), ("empty",)),
    "adreft": (("train", "adreft", "--policy", "modular", "--config", "{}/f.yaml", "--out", "out"), ("empty",)),
    "changes": (("train", "changes", "{}/f.safetensors", "--policy", "modular", "--out", "out"), ()),
    "adjusted": (("train", "adjust", "{}/f.safetensors", "--threshold", "0.5", "--out", "out"), ()),
}


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder a hostile file, in which it has every name that some command takes."""
    from roadmend.world.families import sample_scenario
    from roadmend.world.scenario_file import save_scenario

    folder = tmp_path_factory.mktemp("hostile")
    names = {word.removeprefix("{}/") for given, _ in (COMMANDS | TRAINING).values() for word in given if "{}" in word}
    for kind, write in HOSTILE.items():
        (folder / kind).mkdir()
        write(folder / kind / "file")
        for name in names:
            (folder / kind / name).symlink_to("file")
    save_scenario(sample_scenario("S3", 7), folder / "scenario.yaml")
    return folder


@pytest.fixture
def refused(files, capfd, monkeypatch):
    monkeypatch.chdir(files)
    monkeypatch.setattr("roadmend.nodes.launcher._GraphRun", lambda *_: pytest.fail("started the graph"))

    def run(given, kind, codes=(2,)):
        before, grown = sorted(files.rglob("*")), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        code = main([word.format(kind) for word in given])
        printed = capfd.readouterr()
        lines = printed.err.splitlines()
        assert code in codes, (code, printed)
        assert len(lines) == 1, lines
        assert code == 1 or lines[0].startswith("roadmend: ")
        assert code == 1 or not printed.out
        assert len(lines[0]) < 1000
        assert sorted(files.rglob("*")) == before
        assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - grown < MEMORY

    return run


@pytest.mark.timeout(60)
@pytest.mark.parametrize("kind", HOSTILE)
@pytest.mark.parametrize("command", COMMANDS)
def test_a_hostile_file_is_refused_in_a_line(command, kind, refused):
    given, harmless = COMMANDS[command]
    if kind not in harmless:
        refused(given, kind, (1, 2) if command in _OF_SEVERAL else (2,))


@pytest.mark.timeout(60)
@pytest.mark.parametrize("command", TRAINING)
def test_a_hostile_file_is_refused_in_a_line_by_what_trains(command, refused):
    given, harmless = TRAINING[command]
    for kind in HOSTILE.keys() - {*harmless}:
        refused(given, kind)
