"""Rows of an earlier table stand beside fresh ones: whole, in order, and paired anew."""

from copy import deepcopy
from dataclasses import replace

import pytest

from harness.benchmark_content import build_content, case_table
from harness.benchmark_files import read_json
from harness.benchmark_tables import all_tables
from harness.kept_rows import (
    check_sizes,
    keep_cases,
    keep_controls,
    keep_cost,
    keep_ordinary,
    keep_robustness,
    paired_cases,
)
from harness.options import PLANS
from roadmend.core.errors import InputError
from roadmend.measures.repair import intervals_of
from roadmend.reports.result_files import origin
from tests.benchmarks.made_up import MADE, measured
from tests.measures.results import run

ORDER = ["none", "rule", "adreft", "hindsight"]
DIGESTS = {"modular": [result.episode.digest for result in measured().results["none"]]}
LATER = {**MADE, "commit": "fedcba9876543210", "command": "./roadmend bench adreft --methods adreft --keep"}


def table_of(one, made=MADE):
    return build_content([one], dict(made), {}), case_table([one])


def only(one, **results):
    """The benchmark with some methods alone."""
    contenders = tuple(each for each in one.benchmark.contenders if each.name in results)
    return replace(one, benchmark=replace(one.benchmark, contenders=contenders), results=results, confusions={})


def test_what_is_kept_is_the_whole_table_again_where_nothing_has_changed():
    whole, cases = table_of(measured())
    adreft = measured().results["adreft"]
    fresh, fresh_cases = table_of(only(measured(), adreft=adreft), LATER)
    keep_cases(fresh, fresh_cases, whole, cases, DIGESTS, ORDER)
    assert fresh_cases == cases
    assert [*fresh["summary"]["modular"]] == ORDER
    for part in ("titles", "monitor", "contenders", "corpora"):
        assert fresh[part] == whole[part]
    for policy, methods in whole["summary"].items():
        for name, figures in methods.items():
            found = fresh["summary"][policy][name]
            more, then = (each.pop("adreft_minus_this", None) for each in (found, figures))
            assert {**found, "bound": None} == {**figures, "bound": None}
            if then is not None:
                assert more["dose"] == pytest.approx(then["dose"])
                assert {**more, "dose": None} == {**then, "dose": None}
    assert fresh["provenance"]["kept"] == [
        {"commit": MADE["commit"], "command": MADE["command"], "methods": ["none", "rule", "hindsight"]}
    ]
    assert "Kept from `./roadmend bench adreft` at commit 0123456789ab: none, rule, hindsight." in origin(
        fresh["provenance"]
    )


def test_who_leads_is_found_anew():
    whole, cases = table_of(measured())
    fresh, fresh_cases = table_of(only(measured(), adreft=run("GGGGGGGG", 10, 6.0)), LATER)
    keep_cases(fresh, fresh_cases, whole, cases, DIGESTS, ORDER)
    more = fresh["summary"]["modular"]["rule"]["adreft_minus_this"]
    own, rule = (fresh["summary"]["modular"][name]["delta_e"] for name in ("adreft", "rule"))
    assert more["delta_e"] == pytest.approx(own - rule)
    assert more != whole["summary"]["modular"]["rule"]["adreft_minus_this"]


def test_rows_keep_the_commit_that_they_had():
    whole, cases = table_of(measured())
    second, second_cases = table_of(only(measured(), adreft=measured().results["adreft"]), LATER)
    keep_cases(second, second_cases, whole, cases, DIGESTS, ORDER)
    third, third_cases = table_of(only(measured(), rule=measured().results["rule"]), {**LATER, "commit": "3" * 16})
    keep_cases(third, third_cases, second, second_cases, DIGESTS, ORDER)
    assert [(entry["commit"], entry["methods"]) for entry in third["provenance"]["kept"]] == [
        (MADE["commit"], ["none", "hindsight"]),
        (LATER["commit"], ["adreft"]),
    ]


def test_what_the_plan_has_no_more_is_dropped():
    whole, cases = table_of(measured())
    fresh, fresh_cases = table_of(only(measured(), adreft=measured().results["adreft"]))
    keep_cases(fresh, fresh_cases, whole, cases, DIGESTS, [name for name in ORDER if name != "rule"])
    assert "rule" not in fresh["summary"]["modular"]
    assert "rule" not in fresh_cases["modular"]["methods"]
    assert "none" in fresh["summary"]["modular"]


def test_other_cases_are_refused():
    whole, cases = table_of(measured())
    fresh, fresh_cases = table_of(only(measured(), adreft=measured().results["adreft"]))
    for other in ({"modular": [*reversed(DIGESTS["modular"][:-1]), "e" * 64]}, {"modular": []}):
        with pytest.raises(InputError, match="other cases of the policy modular"):
            keep_cases(deepcopy(fresh), deepcopy(fresh_cases), whole, cases, other, ORDER)
    cases["modular"]["names"].reverse()
    with pytest.raises(InputError, match="other cases of the policy modular"):
        keep_cases(fresh, fresh_cases, whole, cases, DIGESTS, ORDER)


def test_a_policy_that_was_not_measured_is_kept_whole():
    both = [measured(), measured("neural")]
    whole, cases = build_content(both, dict(MADE), {}), case_table(both)
    fresh, fresh_cases = table_of(only(measured("neural"), adreft=run("GGGGGGGG", 10, 6.0)), LATER)
    digests = {"neural": DIGESTS["modular"]}
    keep_cases(fresh, fresh_cases, whole, cases, digests, [*ORDER, "wo_sr"])
    assert fresh["policies"] == ["modular", "neural"]
    assert fresh_cases["modular"] == cases["modular"]
    for table in (fresh_cases, *(fresh[part] for part in ("corpora", "contenders", "summary", "monitor"))):
        assert [*table] == ["modular", "neural"]
    for part in ("corpora", "contenders", "monitor"):
        assert fresh[part]["modular"] == whole[part]["modular"]
    for name, figures in whole["summary"]["modular"].items():
        assert fresh["summary"]["modular"][name]["delta_e"] == figures["delta_e"]
    assert [*fresh["families"]] == [*whole["families"]]
    assert {entry["policy"] for entry in fresh["not_run"]} == {"modular", "neural"}
    assert "modular: adreft" in fresh["provenance"]["kept"][0]["methods"]
    assert len(all_tables(fresh)) == len(all_tables(whole))


def test_the_cost_of_what_was_not_timed_now_is_kept():
    before = {name: {"median_ms": value} for name, value in (("rule", 1.0), ("gone", 2.0), ("torch_eager", 3.0))}
    found = keep_cost({"adreft": {"median_ms": 9.0}, "torch_eager": {"median_ms": 4.0}}, before, ORDER)
    assert {name: figures["median_ms"] for name, figures in found.items()} == {
        "rule": 1.0,
        "adreft": 9.0,
        "torch_eager": 4.0,
    }
    assert [*found] == ["rule", "adreft", "torch_eager"]
    assert keep_cost({}, {}, ORDER) == {}


def drives(time_lost, count=979, collisions=21):
    return {"drives": count, "collisions_bare": collisions, "time_lost": time_lost}


def test_of_prices_that_are_kept_no_lead_is_told():
    point = {"delta_e": 50.0, "lead": {"delta_e": 3.0, "interval": [1.0, 5.0]}}
    before = {
        "provenance": MADE,
        "ordinary": {"random": {"modular": {"none": drives(1), "rule": drives(2), "adreft": drives(3)}}},
        "curve": {"modular": {"rule": [1], "adreft": [2]}},
        "at_time_lost": {"modular": {"rule": {"1": None, "2": point}}},
    }
    content = {
        "provenance": dict(LATER),
        "ordinary": {
            "random": {"modular": {"none": drives(1), "adreft": drives(4)}},
            "given": {"modular": {"adreft": drives(5, 4)}},
        },
        "curve": {},
        "at_time_lost": {"modular": {"adreft": {"1": None, "2": point}}},
    }
    keep_ordinary(content, before, ORDER)
    assert content["ordinary"] == {
        "random": {"modular": {"none": drives(1), "rule": drives(2), "adreft": drives(4)}},
        "given": {"modular": {"adreft": drives(5, 4)}},
    }
    assert content["curve"] == before["curve"]
    assert content["at_time_lost"]["modular"]["rule"] == {"1": None, "2": {**point, "lead": None}}
    assert content["at_time_lost"]["modular"]["adreft"]["2"]["lead"] == point["lead"]
    assert content["provenance"]["kept"][0]["methods"] == ["rule", "adreft"]


def test_prices_of_which_none_is_measured_anew_are_kept_whole_and_named():
    lead = {"delta_e": 5.0, "interval": [1.0, 9.0]}
    earlier = {"commit": "4" * 16, "command": "./roadmend bench ordinary --methods rule --keep", "methods": ["rule"]}
    before = {
        "provenance": {**MADE, "kept": [earlier]},
        "ordinary": {"random": {"modular": {"none": drives(1), "rule": drives(2), "adreft": drives(3)}}},
        "curve": {"modular": {"rule": [1], "adreft": [2]}},
        "at_time_lost": {"modular": {"rule": {"1": {"setting": "a", "lead": lead}}}},
    }
    fresh = {name: drives(value, 5) for value, name in enumerate(["none", "rule", "adreft"], 4)}
    content = {
        "provenance": dict(LATER),
        "ordinary": {"random": {"modular": dict(fresh)}},
        "curve": {},
        "at_time_lost": {},
    }
    check_sizes(f"{ORDINARY} --count 5 --networks 9 --drives 9 --keep", before, is_whole=True)
    with pytest.raises(InputError, match="--count 200, not 5"):
        check_sizes(f"{ORDINARY} --count 5 --keep", before)
    keep_ordinary(content, before, ORDER)
    assert content["ordinary"] == {"random": {"modular": fresh}}
    assert (content["curve"], content["at_time_lost"]) == (before["curve"], before["at_time_lost"])
    assert [(entry["commit"], entry["methods"]) for entry in content["provenance"]["kept"]] == [
        (MADE["commit"], ["what is fixed at a given loss of time"]),
        (earlier["commit"], ["rule"]),
    ]


@pytest.mark.parametrize(("count", "collisions"), [(98, 21), (979, 20)])
def test_ordinary_drives_of_another_number_or_end_are_no_company(count, collisions):
    before = {
        "provenance": MADE,
        "ordinary": {"random": {"modular": {"none": drives(1), "adreft": drives(3)}}},
        "curve": {},
        "at_time_lost": {},
    }
    fresh = {
        "provenance": dict(LATER),
        "ordinary": {"random": {"modular": {"none": drives(1, count, collisions)}}},
        "curve": {},
        "at_time_lost": {},
    }
    with pytest.raises(InputError, match="figures of modular on random are of other drives"):
        keep_ordinary(fresh, before, ORDER)


ORDINARY = "./roadmend bench ordinary"


def test_needs_that_were_told_by_more_futures_are_not_mixed():
    before = {"provenance": {"command": f"{ORDINARY} --futures 10", "commit": "0" * 12}}
    check_sizes(f"{ORDINARY} --methods rss --keep", before)
    with pytest.raises(InputError, match="--keep: the committed figures are of --futures 10, not 5"):
        check_sizes(f"{ORDINARY} --methods rss --futures 5 --keep", before)


@pytest.mark.parametrize(
    "words",
    [
        "--count 20",
        "--networks 1 --drives 2",
        "--networks 2 --drives 3",
        "--curve-count 5 --curve-cases 10",
        "--curve-count 60 --curve-cases 20",
        "--curve-count 60 --curve-cases 10 --table-cases 3",
    ],
)
def test_what_was_measured_on_less_is_not_mixed_with_the_committed_figures(words):
    committed = read_json(PLANS / "adreft-ordinary.json")
    with pytest.raises(InputError, match=r"--keep: the committed figures are of --\S+ \S+, not \d+"):
        check_sizes(f"{ORDINARY} --methods rss {words} --keep", committed)


@pytest.mark.parametrize(
    "words",
    [
        "",
        "--networks 2 --drives 2",
        "--curve-count 60 --curve-cases 10",
        "--table-cases 3",
        "--sumocfg a.sumocfg --drives 9",
        "--futures 5",
    ],
)
def test_the_committed_figures_can_be_kept_beside_as_much_and_beside_what_they_have_not(words):
    committed = read_json(PLANS / "adreft-ordinary.json")
    check_sizes(f"{ORDINARY} --methods rss {words} --keep", committed)
    alone = {policy: {"none": dict(rows["none"])} for policy, rows in committed["ordinary"]["random"].items()}
    fresh = {"provenance": dict(LATER), "ordinary": {"random": alone}, "curve": {}, "at_time_lost": {}}
    keep_ordinary(fresh, committed, [*committed["titles"]])
    assert fresh["ordinary"] == committed["ordinary"]


def test_what_was_kept_of_one_policy_alone_is_called_with_it():
    def study(made, **policies):
        each = {policy: {"random": found} for policy, found in policies.items()}
        return {
            "provenance": dict(made),
            "techniques": ["random"],
            "families": [],
            "runs": 1,
            "budget": 1,
            "policies": each,
        }

    whole = study(MADE, modular={"none": 1, "adreft": 2}, neural={"none": 3, "adreft": 4})
    second = study(LATER, neural={"adreft": 5})
    keep_robustness(second, whole, ORDER)
    assert list(second["policies"]) == ["modular", "neural"]
    assert second["provenance"]["kept"] == [
        {"commit": MADE["commit"], "command": MADE["command"], "methods": ["none", "modular: adreft"]}
    ]
    third = study({**LATER, "commit": "3" * 16}, modular={"adreft": 6})
    keep_robustness(third, second, ORDER)
    assert [(entry["commit"], entry["methods"]) for entry in third["provenance"]["kept"]] == [
        (MADE["commit"], ["none"]),
        (LATER["commit"], ["neural: adreft"]),
    ]


def controls_of(made=MADE, cases=4, bound=True, **delta_e):
    shuffled = {name: {"violations": cases, "successes": cases, "delta_e": value} for name, value in delta_e.items()}
    bounds = {"modular": {"informed": {"dose": 1.0, "adreft_dose": 2.0}}} if bound else {}
    return {"provenance": dict(made), "controls": {"modular": {"shuffled": shuffled}}, "bound": bounds}


def test_controls_that_were_not_run_are_kept_and_so_is_the_bound():
    fresh = controls_of(LATER, bound=False, adreft=70.0)
    keep_controls(fresh, controls_of(rule=40.0, adreft=60.0), ORDER)
    figures = fresh["controls"]["modular"]["shuffled"]
    assert {name: each["delta_e"] for name, each in figures.items()} == {"rule": 40.0, "adreft": 70.0}
    assert [*figures] == ["rule", "adreft"]
    assert fresh["bound"]["modular"]["informed"] == {"dose": 1.0, "adreft_dose": None}
    assert fresh["provenance"]["kept"][0]["methods"] == ["rule", "informed bound"]
    same = controls_of(LATER, bound=False, adreft=60.0)  # the same drives: their dose beside the bound still holds
    keep_controls(same, controls_of(rule=40.0, adreft=60.0), ORDER)
    assert same["bound"]["modular"]["informed"] == {"dose": 1.0, "adreft_dose": 2.0}


def test_a_policy_that_was_left_out_is_kept_whole():
    before = controls_of(adreft=60.0)
    before["controls"]["neural"] = {"shuffled": {"adreft": {"violations": 4, "successes": 4, "delta_e": 50.0}}}
    fresh = controls_of(LATER, adreft=70.0)
    keep_controls(fresh, before, ORDER)
    assert {name: each["shuffled"]["adreft"]["delta_e"] for name, each in fresh["controls"].items()} == {
        "modular": 70.0,
        "neural": 50.0,
    }


def test_controls_of_other_cases_are_no_company():
    with pytest.raises(InputError, match="of other cases"):
        keep_controls(controls_of(LATER, cases=3, adreft=70.0), controls_of(rule=40.0), ORDER)


def study_of(made=MADE, budget=100, **found):
    curves = {name: {"found": [[0, value]]} for name, value in found.items()}
    alike = {"techniques": ["random"], "families": ["S1"], "runs": 1, "budget": budget}
    return {"provenance": dict(made), "policies": {"modular": {"random": curves}}, **alike}


def test_searches_that_were_not_run_are_kept_if_they_were_as_long():
    fresh = study_of(LATER, adreft=3)
    keep_robustness(fresh, study_of(none=9, adreft=5), ORDER)
    assert fresh["policies"]["modular"]["random"] == {"none": {"found": [[0, 9]]}, "adreft": {"found": [[0, 3]]}}
    assert fresh["provenance"]["kept"][0]["methods"] == ["none"]
    with pytest.raises(InputError, match="did not search alike"):
        keep_robustness(study_of(LATER, budget=50, adreft=3), study_of(none=9), ORDER)


@pytest.mark.parametrize("stem", ["adreft", "adreft-fresh-20264"])
def test_the_committed_intervals_are_those_of_the_committed_cases(stem):
    content, cases = read_json(PLANS / f"{stem}.json"), read_json(PLANS / f"{stem}-cases.json")
    for policy, table in cases.items():
        for method in table["methods"]:
            told = content["summary"][policy][method]["intervals"]
            found = intervals_of(paired_cases(table, method))
            # the cases' doses are rounded in their file; measured intervals are of the whole ones
            near = {name: each and pytest.approx(each, rel=1e-4) for name, each in told.items()}
            assert near == found, (policy, method)
