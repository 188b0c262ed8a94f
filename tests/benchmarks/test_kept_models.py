"""A kept row tells whether it is of today's model; what tells nothing is of an unknown one."""

import pytest

from harness.contenders import read_plan, resolve
from harness.grid import Setting
from harness.kept_models import mark_models, row_title
from harness.options import PLANS
from harness.price_curve import curve_settings, points_of
from roadmend.core.resources import config_folder

PLAN = read_plan(PLANS / "adreft.yaml")


@pytest.fixture(scope="module")
def now():
    """How two methods describe themselves today, one of them with a model."""
    found, _ = resolve(PLAN, config_folder(), "modular", ["rss", "adreft"])
    return {contender.name: contender.describe() for contender in found}


def of_another(described):
    return {**described, "model": {**described["model"], "digest": "0" * 64}}


def test_rows_of_earlier_and_of_unknown_models_are_marked(now):
    point = {"delta_e": 1.0, "contender": of_another(now["adreft"])}
    content = {
        "ordinary": {
            "random": {"modular": {"rss": {}, "gated": {}, "adreft": {"contender": now["adreft"], "kept_model": "x"}}},
            "city": {"modular": {"adreft": {"contender": of_another(now["adreft"])}, "rss": {"contender": now["rss"]}}},
        },
        "at_time_lost": {"modular": {"adreft": {"1": None, "2": point}}},
        "controls": {"modular": {"shuffled": {"adreft": {}}}},
    }
    mark_models(content, PLAN, config_folder())
    random, city = (content["ordinary"][name]["modular"] for name in ("random", "city"))
    assert {method: row.get("kept_model") for method, row in random.items()} == {
        "rss": None,
        "gated": "unknown",
        "adreft": None,
    }
    assert {method: row.get("kept_model") for method, row in city.items()} == {"adreft": "earlier", "rss": None}
    assert point["kept_model"] == "earlier"
    assert content["controls"]["modular"]["shuffled"]["adreft"]["kept_model"] == "unknown"


def test_the_tables_say_so():
    titles = {"adreft": "ADReFT"}
    assert row_title(titles, "adreft", {"kept_model": "earlier"}) == "ADReFT (earlier model)"
    assert row_title(titles, "adreft", {}) == row_title(titles, "adreft", None) == "ADReFT"


def test_a_setting_and_its_point_have_the_models_digest(now):
    (contender,), _ = resolve(PLAN, config_folder(), "modular", ["adreft"])
    assert Setting.of(contender).contender["model"]["digest"] == now["adreft"]["model"]["digest"]
    settings = curve_settings(PLAN, config_folder(), "modular", ["adreft"])[:1]
    repair = {"violations": 1, "successes": 1, "fix": 1.0, "deg": 0.0, "delta_e": 1.0, "dose": 1.0}
    cases = {"repair": {**repair, "intervals": {"delta_e": None}}}
    drives = {"ordinary": {"time_lost": 1.0, "untouched": 1.0, "new_collisions": 0}}
    figures = tuple({"modular": {settings[0].title: found}} for found in (cases, drives))
    (point,) = points_of(settings, figures)["adreft"]
    assert point["contender"]["model"] == now["adreft"]["model"]
    assert point["contender"]["parameters"] == point["parameters"]
