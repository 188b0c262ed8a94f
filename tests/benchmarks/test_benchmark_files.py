import base64
import json
import math
import re
from html.parser import HTMLParser
from xml.etree import ElementTree as ET

import pytest

from harness.benchmark_content import build_content, case_table, differences, dump_json, unequal
from harness.benchmark_files import read_json, write_benchmark
from roadmend.core.errors import InputError
from tests.benchmarks.made_up import MADE, measured
from tests.measures.results import CASES

COST = {"adreft": {"median_ms": 0.25, "p99_ms": 0.5, "ratio": 0.2}, "rule": {"median_ms": 0.02, "p99_ms": 0.05}}
ROBUSTNESS = {
    "techniques": ["random", "avfuzzer"],
    "policies": {
        "modular": {
            technique: {
                "none": {"evaluations": [0, 10, 20], "found": [[0, 3, 7], [0, 2, 5], [0, 4, 6]]},
                "adreft": {"evaluations": [0, 10, 20], "found": [[0, 0, 1], [0, 0, 0], [0, 1, 1]]},
            }
            for technique in ("random", "avfuzzer")
        }
    },
}


class Page(HTMLParser):
    """Keeps tables and images, and minds that every element is closed."""

    VOID = ("meta", "img", "br")

    def __init__(self):
        super().__init__()
        self.open, self.images, self.links, self.tables, self.cells = [], [], [], [], None

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        if tag not in self.VOID:
            self.open.append(tag)
        if tag == "img":
            self.images.append(given["src"])
        if tag in {"a", "link", "script"}:
            self.links.append(given.get("href") or given.get("src"))
        if tag == "table":
            self.tables.append([])
        if tag == "tr":
            self.tables[-1].append([])
        if tag in {"td", "th"}:
            self.tables[-1][-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in {"td", "th"}:
            self.tables[-1][-1][-1] += data


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    parts = [measured()]
    content = build_content(parts, MADE, {"families": ["S1", "S2"], "cases": None})
    content |= {"cost": COST, "robustness": ROBUSTNESS}
    write_benchmark(folder, "adreft", content, case_table(parts))
    return folder


def test_the_json_holds_what_was_promised(written):
    content = read_json(written / "adreft.json")
    keys = ("fix", "deg", "delta_e", "intensity", "dose", "intervened_frames", "fix_loose")
    ours = content["summary"]["modular"]["adreft"]
    assert [ours[key] for key in keys] == [75.0, 0.0, 75.0, 0.6, pytest.approx(0.3), 10.0, 100.0]
    assert {*keys} <= {*content["families"]["S2"]["modular"]["rule"]}
    assert content["families"]["S2"]["modular"]["rule"]["deg"] == 50.0
    assert content["monitor"]["modular"]["adreft"]["recall"] == 80.0
    assert content["cost"]["adreft"] == COST["adreft"]
    assert ours["bound"]["fix_share"] == 100.0
    assert content["summary"]["modular"]["rule"]["adreft_minus_this"]["delta_e"] == 75.0
    assert content["corpora"]["modular"]["not_reproduced"] == []
    assert content["not_run"] == [{"policy": "modular", "method": "wo_sr", "reason": "there is no model <wo_sr>"}]


def test_no_place_of_this_machine_and_no_infinity_is_written(written):
    for path in written.iterdir():
        text = path.read_text()
        assert str(written) not in text
        assert not re.search(r"\b(NaN|Infinity)\b", text) or path.suffix == ".html"


def test_the_page_is_whole_and_needs_nothing_else(written):
    page = Page()
    page.feed((written / "adreft.html").read_text())
    assert page.open == []
    assert len(page.images) == 8
    for source in page.images:
        kind, _, data = source.partition(",")
        assert kind == "data:image/svg+xml;base64"
        assert ET.fromstring(base64.b64decode(data)).tag.endswith("svg")
    assert all(link.startswith("#") for link in page.links)
    assert "<processor>" not in (written / "adreft.html").read_text()


def test_page_and_markdown_say_what_the_json_says(written):
    content = read_json(written / "adreft.json")
    page = Page()
    page.feed((written / "adreft.html").read_text())
    head, *rows = page.tables[0]
    by_title = {row[0]: row for row in rows}
    main = (written / "adreft.md").read_text().splitlines()
    for method, title in (("rule", "RuleRepair"), ("adreft", "ADReFT")):
        figures = content["summary"]["modular"][method]
        low, high = figures["intervals"]["delta_e"]
        expected = [
            title,
            f"{figures['fix']:.1f}",
            f"{figures['deg']:.1f}",
            f"{figures['delta_e']:.1f} ({low:.1f} .. {high:.1f})",
            f"{figures['intensity']:.2f}",
            f"{figures['dose']:.2f}",
        ]
        assert by_title[title] == expected
        assert "| " + " | ".join(expected) + " |" in main
    assert head == ["method", "modular: %Fix", "%Deg", "ΔE", "intensity", "dose [s]"]
    tables = (written / "adreft-tables.md").read_text()
    assert "| modular | avfuzzer | no repair | 20 | 6.0 | 5 .. 7 |" in tables
    assert "there is no model <wo_sr>" in tables
    assert any("there is no model <wo_sr>" in row for table in page.tables for row in table)


def test_the_same_results_give_the_same_files(written, tmp_path):
    parts = [measured()]
    content = build_content(parts, MADE, {"families": ["S1", "S2"], "cases": None})
    content |= {"cost": COST, "robustness": ROBUSTNESS}
    write_benchmark(tmp_path, "adreft", content, case_table(parts))
    for path in written.iterdir():
        assert (tmp_path / path.name).read_bytes() == path.read_bytes()


def test_a_difference_to_the_committed_cases_is_named():
    kept = json.loads(dump_json(case_table([measured()])))
    fresh = json.loads(json.dumps(kept))
    assert differences(fresh, kept) == []
    columns = kept["modular"]["methods"]["adreft"]
    columns["outcomes"] = "C" + columns["outcomes"][1:]
    (moved,) = differences(fresh, kept)
    assert moved.text.startswith("modular, adreft, a: G, 10 frames, 0.3 s, ")
    assert moved.ends_otherwise
    del kept["modular"]["methods"]["rule"]
    assert "modular, rule: is not in the committed table" in {each.text for each in differences(fresh, kept)}
    assert unequal({"a": {"b": 1.0}}, {"a": {"b": 2.0, "c": 3}}) == ["a.b: 1.0 instead of 2.0"]
    assert len(CASES) == len(fresh["modular"]["names"])


def test_cases_that_run_otherwise_than_their_corpus_says_are_named():
    changed = measured()
    changed.results["none"] = changed.results["adreft"]
    assert changed.unreproduced == ("a", "b", "c", "d")


def test_lists_of_values_stay_on_one_line():
    assert dump_json({"a": [1, 2.5], "b": [{"c": None}], "d": {}}) == (
        '{\n  "a": [1, 2.5],\n  "b": [\n    {\n      "c": null\n    }\n  ],\n  "d": {}\n}'
    )
    with pytest.raises(ValueError):
        dump_json({"a": math.nan})


def test_damaged_files_and_folders_that_cannot_be_written(tmp_path):
    (tmp_path / "adreft.json").write_text("{")
    with pytest.raises(InputError, match="is damaged"):
        read_json(tmp_path / "adreft.json")
    with pytest.raises(InputError, match="cannot be read"):
        read_json(tmp_path / "other.json")
    parts = [measured()]
    content = build_content(parts, MADE, {})
    with pytest.raises(InputError, match="cannot be written"):
        write_benchmark(tmp_path / "adreft.json", "adreft", content, case_table(parts))
