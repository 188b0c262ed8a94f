"""``roadmend sera`` on small banks."""

import json
import re
from pathlib import Path

import pytest

from roadmend.cli.main import main
from roadmend.sera.pattern import FailurePattern, PatternEvidence, Where, Why, dump_patterns, read_patterns

DEMO = Path(__file__).parents[2] / "config" / "scenarios" / "demo-exit.yaml"


@pytest.fixture(scope="module")
def bank(tmp_path_factory):
    path = tmp_path_factory.mktemp("sera") / "small.bank"
    assert main(["sera", "bank", "build", "--sample", "6", "--out", str(path), str(DEMO), str(DEMO)]) == 0
    return path


def test_a_bank_of_families_and_files_is_shown(bank, capsys):
    assert main(["sera", "bank", "show", "--bank", str(bank), "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert shown["scenarios"] == 31  # six of each family and the file, which was given twice
    assert shown["family"] == {"S4": 7, "S1": 6, "S2": 6, "S3": 6, "S5": 6}
    assert shown["outcome"] == {"never run": 31}
    assert main(["sera", "bank", "show", "--bank", str(bank)]) == 0
    assert "31 scenarios" in capsys.readouterr().out


def test_search_finds_in_words_and_under_filters(bank, capsys):
    command = ["sera", "bank", "search", "--bank", str(bank), "--pattern", "cut-in at a highway exit", "-k", "4"]
    assert main([*command, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert len(found) == 4
    assert all(each["words"].startswith("highway exit") and "cuts in" in each["words"] for each in found)
    assert main([*command, "--family", "S5", "--json"]) == 0
    assert all(each["words"].startswith("on-ramp") for each in json.loads(capsys.readouterr().out))
    assert main([*command, "--weather", "hail"]) == 2
    assert "weather: there is no 'hail'" in capsys.readouterr().err


@pytest.mark.parametrize("command", [["bank", "search"], ["recommend"]])
def test_brackets_in_a_pattern_are_no_styles(bank, capsys, command):
    words = "cut-in [/x] [s3]"
    assert main(["sera", *command, "--bank", str(bank), "--pattern", words, "-k", "1"]) == 0
    assert words in capsys.readouterr().out


def test_an_export_comes_back_as_the_same_bank(bank, tmp_path, capsys):
    lines, again = tmp_path / "all.jsonl", tmp_path / "again.bank"
    assert main(["sera", "bank", "export", "--bank", str(bank), "--out", str(lines)]) == 0
    assert main(["sera", "bank", "import", str(lines), "--out", str(again)]) == 0
    assert again.read_bytes() == bank.read_bytes()
    # Added to the bank that it came from, it changes nothing.
    assert main(["sera", "bank", "import", str(lines), "--bank", str(again), "--out", str(again), "--json"]) == 0
    assert again.read_bytes() == bank.read_bytes()
    printed = capsys.readouterr().out
    assert json.loads(printed[printed.index("{") :])["merged"] == 31


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: [], "is no export of a bank"),
        (
            lambda lines: ['{"format": "roadmend-bank-export/9", "entries": 1}'],
            "has the format 'roadmend-bank-export/9'",
        ),
        (lambda lines: lines[:-1], "holds 30 of 31 entries"),
        (lambda lines: [*lines[:2], "{", *lines[3:]], "line 3: broken JSON"),
        (lambda lines: [lines[0], '{"digest": "x"}'], "line 2: has other fields than"),
        (lambda lines: [lines[0], lines[1].replace('"weather":"', '"weather":"x')], "line 2: field weather"),
        (lambda lines: [lines[0], lines[1].replace('"seed":', '"seed":1')], "line 2: has another digest"),
        (lambda lines: [lines[0], re.sub('"friction":[^,]+', '"friction":1e999', lines[1], count=1)], "field friction"),
        (lambda lines: [lines[0], lines[1].replace('"car":', '"car":-')], "line 2: field participants.car"),
    ],
)
def test_a_bad_export_is_refused_and_leaves_nothing(bank, tmp_path, capsys, change, message):
    lines = tmp_path / "all.jsonl"
    assert main(["sera", "bank", "export", "--bank", str(bank), "--out", str(lines)]) == 0
    lines.write_text("".join(line + "\n" for line in change(lines.read_text().splitlines())))
    capsys.readouterr()
    assert main(["sera", "bank", "import", str(lines), "--out", str(tmp_path / "new.bank")]) == 2
    error = capsys.readouterr().err.strip().splitlines()[-1]
    assert message in error
    assert [path.name for path in tmp_path.iterdir()] == ["all.jsonl"]


def test_recommend_from_a_pattern_file(bank, tmp_path, capsys):
    patterns = [
        FailurePattern(
            "exit", "cut-in", where=Where(road="highway_exit"), evidence=(PatternEvidence("bags/x", "d", 3.0),)
        ),
        FailurePattern("turn", why=Why("left_turn", "run_right_of_way")),
    ]
    file = tmp_path / "patterns.json"
    file.write_text(dump_patterns(patterns))
    assert read_patterns(str(file)) == patterns
    command = ["sera", "recommend", "--bank", str(bank), "--pattern", str(file), "-k", "2", "--exclude", str(DEMO)]
    assert main([*command, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    for name in ("initial", "refined", "random"):
        assert [each["pattern"] for each in found[name]].count("turn") == 2
        assert "demo-exit" not in [each["name"] for each in found[name]]
    assert found["measures"]["refined"]["coverage"] > found["measures"]["random"]["coverage"]
    assert main(command) == 0
    assert "coverage" in capsys.readouterr().out


def test_what_is_excluded_does_not_come_under_another_name_either(bank, tmp_path, capsys):
    renamed, both = tmp_path / "renamed.yaml", tmp_path / "both.bank"
    renamed.write_text(DEMO.read_text().replace("name: demo-exit", "name: the-same"))
    command = ["sera", "bank", "build", "--sample", "6", str(DEMO), str(renamed), "--out", str(both), "--json"]
    assert main(command) == 0
    assert json.loads(capsys.readouterr().out)["merged"] == 1
    command = ["sera", "recommend", "--bank", str(both), "--pattern", "a highway exit", "-k", "31", "--json"]
    for path, kept in (([], 1), (["--exclude", str(DEMO)], 0), (["--exclude", str(renamed)], 0)):
        assert main([*command, *path]) == 0
        assert [each["name"] for each in json.loads(capsys.readouterr().out)["refined"]].count("demo-exit") == kept


def test_words_beyond_the_basic_plane_come_back_from_a_pattern_file(tmp_path):
    patterns = [FailurePattern("exit", "a 🚚 cuts in")]
    file = tmp_path / "patterns.json"
    file.write_text(dump_patterns(patterns))
    assert read_patterns(str(file)) == patterns


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "no such file"),
        ("[]", "holds no pattern"),
        ("{", "broken YAML"),
        ("[{name: x, where: {weather: hail}}]", "field [0].where.weather"),
        ("[{name: x, colour: red}]", "field [0].colour is unknown"),
    ],
)
def test_a_bad_pattern_file_is_refused(bank, tmp_path, capsys, content, message):
    file = tmp_path / "patterns.yaml"
    if content is not None:
        file.write_text(content)
    assert main(["sera", "recommend", "--bank", str(bank), "--pattern", str(file)]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


def test_no_words_and_no_bank_are_refused(bank, tmp_path, capsys):
    assert main(["sera", "recommend", "--bank", str(bank), "--pattern", " "]) == 2
    assert "pattern: is empty" in capsys.readouterr().err
    assert main(["sera", "bank", "show", "--bank", str(tmp_path / "none")]) == 2
    assert "no such file; give a bank" in capsys.readouterr().err
