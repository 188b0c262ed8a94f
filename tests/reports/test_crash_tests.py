"""The reports of SAFE's tests: Markdown and a page that say the same."""

from html.parser import HTMLParser
from urllib.parse import unquote, urlsplit

import pytest

from roadmend.core.errors import InputError
from roadmend.language.chat import Image
from roadmend.reports.crash_tests import report_of_reproductions, report_of_tests
from roadmend.safe.cases import CrashCase
from roadmend.safe.crash_test_summary import summarise_reproductions, summarise_tests
from roadmend.safe.driving import CrashTestResult
from roadmend.safe.judging import JudgedRun
from tests.measures.results import episode
from tests.safe.crashes import crash, vehicle

CASES = [
    CrashCase("head-on", crash("Straight", vehicle("W2E"), vehicle("E2W")), Image(b"sketch", "image/png")),
    CrashCase("empty", None, problem="summary.txt: is empty"),
]
RESULTS = [
    CrashTestResult(
        "head-on", 1, "modular", "scenarios/a.yaml", "pictures/a.png", episode("COLLISION", text="hit <b> | it")
    ),
    CrashTestResult("head-on", 2, "modular", note="no lane & no way"),
]


class Cells(HTMLParser):
    def __init__(self):
        super().__init__()
        self.rows, self.images, self.links = [], [], []

    def handle_starttag(self, tag, attributes):
        if tag == "tr":
            self.rows.append([])
        if tag == "img":
            self.images.append(dict(attributes))
        if tag == "a":
            self.links.append(dict(attributes)["href"])

    def handle_data(self, data):
        if self.get_starttag_text() in {"<th>", "<td>"} and data.strip():
            self.rows[-1].append(data)


def cells_of(page):
    parser = Cells()
    parser.feed(page)
    return parser


def test_the_page_has_the_table_of_the_markdown_and_a_picture_of_each_crash(tmp_path):
    files = report_of_tests(CASES, {"modular": summarise_tests(CASES, RESULTS)}, RESULTS, tmp_path)
    page = cells_of(files["report.html"])
    lines = [line for line in files["report.md"].splitlines() if line.startswith("| ")]
    assert ["| " + " | ".join(row) + " |" for row in page.rows] == [lines[0], *lines[2 : len(page.rows) + 1]]
    assert [image["src"] for image in page.images] == ["pictures/sketch-head-on.png", "pictures/a.png"]
    assert page.images[1]["alt"] == "modular as vehicle 1: hit <b> | it"
    assert (tmp_path / "pictures" / "sketch-head-on.png").read_bytes() == b"sketch"
    assert "modular as vehicle 2: no lane &amp; no way</li>" in files["report.html"]
    assert "not read: summary.txt: is empty" in files["report.html"]
    assert '<a href="pages/head-on.html">head-on</a>' in files["report.html"]
    assert sorted(name for name in files if name.startswith("pages/")) == ["pages/head-on.html"]
    assert "Not read:\n\n- empty: summary.txt: is empty\n" in files["report.md"]
    assert r"hit <b> \| it |" in files["report.md"]


def test_links_lead_to_files_whatever_their_names(tmp_path):
    name = "a#1? 100%"
    case = CrashCase(name, crash("Straight", vehicle("W2E"), vehicle("E2W")), Image(b"sketch", "image/png"))
    result = CrashTestResult(name, 1, "modular", "s.yaml", f"pictures/{name}-v1.png", episode("COLLISION"))
    files = report_of_tests([case], {"modular": summarise_tests([case], [result])}, [result], tmp_path)
    page = cells_of(files["report.html"])
    assert [unquote(image["src"]) for image in page.images] == [f"pictures/sketch-{name}.png", result.picture]
    assert [unquote(link) for link in page.links] == [f"pages/{name}.html"]
    for link in [image["src"] for image in page.images] + page.links:
        assert urlsplit(link).path == link
    assert (tmp_path / unquote(page.images[0]["src"])).is_file()
    assert unquote(page.links[0]) in files


def test_a_sketch_that_browsers_cannot_show_is_left_out(tmp_path):
    case = CrashCase("old", crash("Straight", vehicle("W2E"), vehicle("E2W")), Image(b"sketch", "image/tiff"))
    files = report_of_tests([case], {"modular": summarise_tests([case], [])}, [], tmp_path)
    assert cells_of(files["report.html"]).images == []
    assert not [*tmp_path.iterdir()]


def test_a_reproduction_has_its_own_table(tmp_path):
    files = report_of_reproductions(CASES, {"modular": summarise_reproductions(CASES, RESULTS)}, RESULTS, tmp_path)
    assert cells_of(files["reproduction.html"]).rows[0][:3] == ["policy", "reports", "reproduced"]
    assert "# Crashes reproduced" in files["reproduction.md"]


def test_what_the_judge_says_stands_on_the_page_as_well(tmp_path):
    judged = [
        JudgedRun("head-on", 1, "modular", {"parts": "front <b>, not back"}),
        JudgedRun("head-on", None, "modular", None, "no run"),
    ]
    tallies = {"modular": summarise_reproductions(CASES, RESULTS)}
    files = report_of_reproductions(CASES, tallies, RESULTS, tmp_path, judged)
    rows = cells_of(files["reproduction.html"]).rows
    lines = [line for line in files["reproduction.md"].splitlines() if line.startswith("| ")]
    told = [line for line in lines if line.startswith(("| policy | reports | run", "| report | vehicle | policy | by"))]
    assert len(told) == 2
    assert all(["| " + " | ".join(row) + " |" for row in rows].count(line) == 1 for line in told)
    assert "<h2>By the records</h2>" in files["reproduction.html"]
    assert ["head-on", "onlooker", "modular", "-", "no run"] in rows
    assert "By the records" not in report_of_reproductions(CASES, tallies, RESULTS, tmp_path)["reproduction.html"]


def test_a_sketch_never_goes_through_a_link_nor_is_left_half_written(tmp_path):
    tallies = {"modular": summarise_tests(CASES, RESULTS)}
    somebodys = tmp_path / "somebodys.png"
    somebodys.write_bytes(b"theirs")
    (tmp_path / "out" / "pictures").mkdir(parents=True)
    (tmp_path / "out" / "pictures" / "sketch-head-on.png").symlink_to(somebodys)
    with pytest.raises(InputError, match=r"sketch-head-on\.png: cannot be written \(a link or a device is there"):
        report_of_tests(CASES, tallies, RESULTS, tmp_path / "out")
    assert somebodys.read_bytes() == b"theirs"
    assert [path.name for path in (tmp_path / "out" / "pictures").iterdir()] == ["sketch-head-on.png"]
