"""The generations of a policy as a chart and as a page."""

import copy
from xml.etree import ElementTree as ET

import pytest

from roadmend.reports.cycle_page import cycle_chart, cycle_page, measure_rows

MEAN = {"mean": 50.0, "interval": [40.0, 60.0]}


def generation(number, score, **changes):
    summary = {
        "episodes": 10,
        "driving_score": {"mean": score, "interval": [score - 5.0, score + 5.0]},
        "success_rate": MEAN,
        "efficiency": {"mean": None, "interval": None},
        "comfortness": {"mean": 80.0, "interval": None},
    }
    return {
        "number": number,
        "policy": f"model-{number}",
        "summary": summary,
        "patterns": ["a <b>truck</b> cuts in"],
        "selected": ["S4-1"],
        "notes": [],
        "faults": [],
    } | changes


TWO = [generation(0, 40.0), generation(1, 55.0, notes=["no failure & nothing more"])]


def test_every_measure_is_drawn_over_the_generations():
    score, success, efficiency, _ = cycle_chart(TWO).axes
    line = max(score.lines, key=lambda each: len(each.get_xdata()) if each.get_marker() == "o" else 0)
    assert [*line.get_xdata()] == [0, 1]
    assert [*line.get_ydata()] == [40.0, 55.0]
    assert [[*each.get_ydata()] for each in score.lines if each is not line] == [[35.0, 45.0], [50.0, 60.0]]
    assert success.get_title(loc="left") == "Success Rate [%]"
    assert [text.get_text() for text in efficiency.texts] == ["nothing to tell"]


def test_the_table_has_a_row_a_generation():
    head, *rows = measure_rows(TWO)
    assert head[:3] == ["generation", "episodes", "Driving Score"]
    assert [row[:3] for row in rows] == [["0", "10", "40.0"], ["1", "10", "55.0"]]


@pytest.mark.parametrize("generations", [TWO, TWO[:1]])
def test_the_page_stands_alone_and_what_is_in_it_is_text(generations):
    before = copy.deepcopy(generations)
    page = cycle_page(generations, "Made by <test>.")
    assert generations == before
    assert "a &lt;b&gt;truck&lt;/b&gt; cuts in" in page
    assert "Made by &lt;test&gt;." in page
    assert "<script" not in page
    assert "src=" not in page
    body = page[page.index("<table") : page.index("</body>")]
    assert len(ET.fromstring(f"<all>{body}</all>").findall("./table/tr")) == len(generations) + 1
    assert page == cycle_page(generations, "Made by <test>.")
