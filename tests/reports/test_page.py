"""Pages from templates: what is put in is text, and what a template asks for has to be there."""

from importlib.resources import files

import pytest
from jinja2 import UndefinedError
from matplotlib.figure import Figure

from roadmend.reports.page import inline_svg, render

CYCLE = {"title": "T", "chart": "", "head": ["a"], "rows": [], "generations": [], "made": "by me"}


def test_what_is_put_in_is_text_unless_it_says_that_it_is_html():
    page = render("cycle.html", **CYCLE | {"title": "</title><b>", "rows": [["<i>", "'"]]})
    assert "<title>&lt;/title&gt;&lt;b&gt;</title>" in page
    assert "<td>&lt;i&gt;</td><td>&#39;</td>" in page
    figure = Figure()
    figure.text(0.5, 0.5, "<b>")
    assert "<svg" in render("cycle.html", **CYCLE | {"chart": inline_svg(figure)})
    assert "<b>" not in inline_svg(figure)


def test_a_name_without_a_value_is_refused():
    with pytest.raises(UndefinedError, match="made"):
        render("cycle.html", **{name: value for name, value in CYCLE.items() if name != "made"})


def test_no_page_asks_for_anything_from_elsewhere():
    templates = [file for file in files("roadmend.reports").joinpath("templates").iterdir() if file.is_file()]
    assert templates
    assert not [file.name for file in templates if "://" in file.read_text(encoding="utf-8")]
