"""Ordinary driving and what is fixed at a price: settings are chosen where they are not shown."""

import json
from dataclasses import asdict, replace

import pytest

from harness import bench_ordinary, grid, price_curve
from harness.bench_ordinary import ordinary
from harness.contenders import read_plan
from harness.options import PLANS
from harness.ordinary_tables import ordinary_tables
from harness.price_curve import add_leads, at_time_lost, curve_settings, points_of
from harness.table import DASH
from roadmend.cli.main import run_group
from roadmend.core.outcome import Blame
from roadmend.core.resources import config_folder
from roadmend.measures.ordinary import ordinary_figures
from tests.measures.results import episode, result


def figures_of(settings, lost, fixed):
    """As if each setting lost so much time, and fixed so much."""
    cases, drives = {}, {}
    for setting, time_lost, fix in zip(settings, lost, fixed, strict=True):
        repair = {"fix": fix, "deg": 0.0, "delta_e": fix, "dose": 1.0, "intervals": {"delta_e": [0.0, 100.0]}}
        repair |= {"violations": 10, "successes": 10}
        cases[setting.title] = {"repair": repair}
        drives[setting.title] = {"ordinary": {"time_lost": time_lost, "untouched": 90.0, "new_collisions": 0}}
    return {settings[0].policy: cases}, {settings[0].policy: drives}


def test_who_stops_dead_and_is_hit_is_told_of():
    goal = replace(episode("GOAL"), duration=20.0, distance=200.0)
    hit = replace(episode("COLLISION", interventions=40, change=40.0, blame=Blame.EGO_STOOD), duration=6.0)
    new = asdict(ordinary_figures([(goal, hit)] * 3))
    kept = {key: value for key, value in new.items() if key not in {"cut_short", "struck_bare", "struck"}}
    rows = {"none": asdict(ordinary_figures([(goal, goal)] * 3)), "rule": new, "rss": kept}
    (table,) = ordinary_tables({"titles": {}, "ordinary": {"random": {"modular": rows}}, "at_time_lost": {}})
    assert table.rows[0][-3:] == ("cut short", "whosever fault: alone", "with repair")
    assert [row[-6:] for row in table.rows[1:]] == [
        ("0", "0", "0", "0", "0", "0"),
        ("0", "0", "0", "3", "0", "3"),
        ("0", "0", "0", *[DASH] * 3),
    ]


def test_every_combination_of_a_curve_is_a_setting():
    plan = read_plan(PLANS / "adreft.yaml")
    settings = curve_settings(plan, config_folder(), "modular", ["rule"])
    assert len(settings) == 5
    assert len({setting.title for setting in settings}) == 5
    assert {setting.parameters["time_to_collision"] for setting in settings} == {1.0, 1.5, 2.0, 3.0, 4.0}
    assert {setting.method for setting in settings} == {"rule"}


def test_the_best_within_the_price_is_chosen_and_shown_where_it_was_not_chosen():
    settings = curve_settings(read_plan(PLANS / "adreft.yaml"), config_folder(), "modular", ["governor"])
    curves = points_of(settings, figures_of(settings, [9.0, 4.0, 1.9, 0.5, 0.1], [90.0, 80.0, 40.0, 60.0, 10.0]))
    assert [point["time_lost"] for point in curves["governor"]] == [0.1, 0.5, 1.9, 4.0, 9.0]
    asked = []

    def drive(_shown, chosen):
        asked.extend(chosen)
        return figures_of(chosen, [3.0] * len(chosen), [33.0] * len(chosen))

    found = at_time_lost(curves, settings, None, drive)["governor"]
    assert [setting.parameters["share"] for setting in asked] == [0.9, 0.8]  # each once
    assert {price: point["chosen_at"]["delta_e"] for price, point in found.items()} == {"1": 60.0, "2": 60.0, "5": 80.0}
    assert {point["delta_e"] for point in found.values()} == {33.0}


def test_a_price_that_no_setting_keeps_to_has_none():
    settings = curve_settings(read_plan(PLANS / "adreft.yaml"), config_folder(), "modular", ["governor"])
    curves = points_of(settings, figures_of(settings, [9.0] * 5, [90.0] * 5))

    def drive(_shown, chosen):
        assert not chosen
        return {}, {}

    assert at_time_lost(curves, settings, None, drive) == {"governor": {"1": None, "2": None, "5": None}}


def test_what_is_shown_has_the_model_of_the_policy_as_what_was_chosen():
    settings = curve_settings(read_plan(PLANS / "adreft.yaml"), config_folder(), "neural", ["adreft"])
    curves = points_of(settings, figures_of(settings, [1.0] * len(settings), [50.0] * len(settings)))
    asked = []

    def drive(_shown, chosen):
        asked.extend(chosen)
        return figures_of(chosen, [1.0] * len(chosen), [50.0] * len(chosen))

    at_time_lost(curves, settings, None, drive)
    assert [setting.parameters["model"].endswith("adreft-neural.safetensors") for setting in asked] == [True]


def test_the_lead_of_adreft_is_paired_by_case_at_the_same_price():
    own = [result(str(number), True, "GOAL") for number in range(4)]
    own += [result(name, False, "GOAL") for name in ("4", "5")]
    other = [result(str(number), True, "COLLISION") for number in range(3)] + [result("3", True, "GOAL")]
    other += [result(name, False, "COLLISION") for name in ("4", "5")]
    found = {
        "adreft": {"1": None, "2": {"setting": "adreft | 0"}},
        "rule": {"1": {"setting": "rule | 0"}, "2": {"setting": "rule | 0"}},
    }
    add_leads(found, {"adreft | 0": own, "rule | 0": other})
    assert found["adreft"]["2"]["lead"]["delta_e"] == 0.0
    assert found["rule"]["1"]["lead"] is None
    assert found["rule"]["2"]["lead"]["delta_e"] == 175.0  # 3 of 4 more are fixed, 2 of 2 fewer spoilt
    assert found["rule"]["2"]["lead"]["interval"][0] > 0.0


@pytest.mark.slow
def test_a_run_gives_json_and_tables(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(price_curve, "FAMILIES", ("S5",))
    monkeypatch.setattr(grid, "FAMILIES", ("S5",))
    words = ["--policy", "modular", "--methods", "governor", "--count", "2", "--curve-count", "1", "--curve-cases", "1"]
    words += ["--table-cases", "1", "--workers", "1", "--work", str(tmp_path / "work"), "--out", str(tmp_path / "out")]
    assert run_group(ordinary, "ordinary", [*words, "--json"]) == 0
    content = json.loads(capsys.readouterr().out)
    found = content["ordinary"]["random"]["modular"]
    assert [*found] == ["none", "governor"]
    assert found["none"]["untouched"] == 100.0
    assert found["governor"]["untouched"] == 0.0
    assert found["governor"]["time_lost"] > 1.0
    assert len(content["curve"]["modular"]["governor"]) == 5
    assert content["provenance"]["command"].startswith("./roadmend bench ordinary --policy modular --methods governor")
    assert json.loads((tmp_path / "out" / "adreft-ordinary.json").read_text()) == content
    assert "Ordinary driving" in (tmp_path / "out" / "adreft-ordinary.md").read_text()


def test_other_random_drives_than_the_tables_can_be_asked_for_but_not_mixed_with_them(tmp_path, capsys, monkeypatch):
    driven = []
    monkeypatch.setattr(bench_ordinary, "random_drives", lambda count, first: driven.append((count, first)) or [])
    monkeypatch.setattr(bench_ordinary, "drive_all", lambda *_: {"modular": {}})
    words = ["--policy", "modular", "--methods", "governor", "--count", "2", "--work", str(tmp_path), "--json"]
    assert run_group(ordinary, "ordinary", words) == 0
    assert run_group(ordinary, "ordinary", [*words, "--first", "7"]) == 0
    assert driven == [(2, grid.TABLE_SEED), (2, 7)]
    assert '--count 2 --first 7"' in capsys.readouterr().out
    for mixed in (["--keep"], ["--curve-count", "1"]):
        assert run_group(ordinary, "ordinary", [*words, "--first", "7", *mixed]) == 2
        assert "--first: --keep and --curve-count go with the table's drives; leave them out" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--methods", "rule, rsss"], "--methods: there is no 'rsss'; choose from none, random_paper"),
        (["--methods", "rss", "--count", "20", "--keep"], "--keep: the committed figures are of --count 200, not 20"),
        (
            ["--sumocfg", "berlin/osm.sumocfg", "--sumocfg", "paris/osm.sumocfg"],
            "--sumocfg paris/osm.sumocfg: there is another set 'osm'; rename the file",
        ),
        (
            ["--policy", "neural", "--first", "68000001", "--count", "100000"],
            "--first: models of neural practise on the drives of the seeds from 68100000 to 68199999; begin elsewhere",
        ),
        (["--sumocfg", "x/random.sumocfg"], "--sumocfg x/random.sumocfg: there is another set 'random'; rename"),
        (["--networks", "1", "--sumocfg", "city.sumocfg"], "--sumocfg city.sumocfg: there is another set 'city'"),
    ],
)
def test_what_cannot_be_measured_or_kept_is_refused_before_anything_is_driven(words, said, capsys, monkeypatch):
    monkeypatch.setattr(bench_ordinary, "drive_all", lambda *_: pytest.fail("was driven"))
    assert run_group(ordinary, "ordinary", [*words, "--committed", str(PLANS)]) == 2
    assert said in capsys.readouterr().err


def test_methods_may_be_separated_by_commas_and_spaces(tmp_path, capsys, monkeypatch):
    asked = []
    monkeypatch.setattr(bench_ordinary, "resolve", lambda *given: asked.append(given[-1]) or ([], []))
    monkeypatch.setattr(bench_ordinary, "drive_all", lambda *_: {"modular": {}})
    words = ["--policy", "modular", "--methods", "rule, rss", "--count", "1", "--work", str(tmp_path), "--json"]
    assert run_group(ordinary, "ordinary", words) == 0
    assert asked == [["rule", "rss"]]
    assert json.loads(capsys.readouterr().out)["provenance"]["command"].endswith("--methods rule,rss --count 1")
