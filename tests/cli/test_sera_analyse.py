"""``roadmend sera analyse`` from the command line."""

import json
import shutil
from pathlib import Path

from roadmend.cli.main import main
from roadmend.sera.pattern import read_patterns

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"


def test_patterns_go_where_recommend_reads_them_and_a_report_beside(tmp_path, capsys):
    out = tmp_path / "new" / "patterns.json"
    assert main(["sera", "analyse", str(SAMPLES / "collision"), "--out", str(out), "--workers", "1", "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    (pattern,) = read_patterns(str(out))
    assert pattern.why.hazard == "cut_in_and_brake"
    assert told["patterns"][0]["name"] == pattern.name
    assert told["incidents"][0]["other"]["name"] == "v8"
    assert "a car cuts in" in out.with_suffix(".md").read_text(encoding="utf-8")


def test_a_corrupt_bag_among_others_is_named_and_the_code_is_1(tmp_path, capsys):
    shutil.copytree(SAMPLES / "collision", tmp_path / "fine")
    shutil.copytree(SAMPLES / "collision", tmp_path / "torn")
    (file,) = (tmp_path / "torn").glob("*.mcap")
    file.write_bytes(file.read_bytes()[:9000])
    assert main(["sera", "analyse", str(tmp_path), "--workers", "1"]) == 1
    printed = capsys.readouterr()
    assert "a car cuts in" in " ".join(printed.out.split())
    assert f"not read: {file}" in printed.err


def test_no_bag_is_one_line_and_code_2(tmp_path, capsys):
    assert main(["sera", "analyse", str(tmp_path)]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "holds no bag" in line
    assert main(["sera", "analyse", str(SAMPLES / "collision"), "--out", str(tmp_path / "report.md")]) == 2
    assert not list(tmp_path.iterdir())
