"""A report read, kept and built, step by step."""

from dataclasses import replace

import pytest

from roadmend.core.errors import InputError
from roadmend.safe import report_build
from roadmend.safe.driving import do
from roadmend.safe.dsl_file import load_crash_scenario
from roadmend.safe.embedded import EmbeddedExtractor
from roadmend.safe.extraction import Step, unwatched
from roadmend.safe.report import report_of_text
from roadmend.safe.report_build import PAGE_REGISTRY, build_report
from roadmend.world.scenario_file import load_scenario

REPORT = report_of_text(
    "told", "V1, a Ford Focus, was northbound on a two-lane road and hit the rear of V2, a Jeep Wrangler."
)


def test_every_vehicle_takes_the_place_of_the_ego(tmp_path):
    steps = []
    built = build_report(REPORT, EmbeddedExtractor(), tmp_path, 1, 0, steps.append)
    assert steps == [Step("read"), Step("build", 1, 2), Step("build", 2, 2)]
    assert load_crash_scenario(tmp_path / "told.json") == built.extraction.scenario
    assert [load_scenario(tmp_path / file).origin.vehicle for file in built.scenarios] == [1, 2]
    assert built.problems == ()


def test_a_scenario_that_was_changed_stays(tmp_path):
    build_report(REPORT, EmbeddedExtractor(), tmp_path, 0, 0, unwatched)
    build_report(REPORT, EmbeddedExtractor(), tmp_path, 0, 0, unwatched)
    file = tmp_path / "told.json"
    edited = file.read_text().replace("Pickup", "Sedan").replace("S2N", "N2S")
    file.write_text(edited)
    with pytest.raises(InputError, match=r"told.json: is no longer what was read from the report 'told'"):
        build_report(REPORT, EmbeddedExtractor(), tmp_path, 1, 0, unwatched)
    assert file.read_text() == edited
    assert not (tmp_path / "scenarios").exists()


def test_a_scenario_that_cannot_be_built_is_a_problem_and_no_end(tmp_path, monkeypatch):
    monkeypatch.setattr(
        report_build, "do", lambda job: do(job) if job.role.ego else replace(do(job), scenario="", note="no room")
    )
    built = build_report(REPORT, EmbeddedExtractor(), tmp_path, 1, 0, unwatched)
    assert built.problems == ("vehicle 1: no room",)
    assert len(built.scenarios) == 1


def test_a_page_is_written_last_of_all(tmp_path):
    written = []

    def write_page(report, extraction, out):
        written.append((report.case, extraction.scenario, sorted(path.name for path in out.glob("*.json"))))
        return out / "told.html"

    built = build_report(REPORT, EmbeddedExtractor(), tmp_path, 0, 0, unwatched, write_page)
    assert built.page == tmp_path / "told.html"
    assert written == [("told", built.extraction.scenario, ["told.evidence.json", "told.json"])]
    assert build_report(REPORT, EmbeddedExtractor(), tmp_path, 0, 0, unwatched).page is None


def test_a_page_is_written_by_what_is_named():
    assert PAGE_REGISTRY.find("none").entry is None
    assert PAGE_REGISTRY.find("roadmend.reports.crash_pages:write_crash_page").entry.__name__ == "write_crash_page"
    with pytest.raises(InputError, match="cannot be called"):
        PAGE_REGISTRY.find("roadmend.safe.report_build:MOST_SAMPLES")


def test_what_watches_may_end_it(tmp_path):
    def watch(step):
        if step == Step("build", 2, 2):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        build_report(REPORT, EmbeddedExtractor(), tmp_path, 1, 0, watch)
    assert len(list((tmp_path / "scenarios").iterdir())) == 1


def test_nothing_is_done_where_too_many_are_asked_for(tmp_path):
    with pytest.raises(InputError, match="1001 is too many; ask for at most 1000"):
        build_report(REPORT, EmbeddedExtractor(), tmp_path, 1001, 0, unwatched)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["", "..", "a/b", "a b", "x" * 101, ".hidden"])
def test_a_name_must_be_one_for_a_file(name):
    with pytest.raises(InputError, match="cannot be a file's"):
        report_of_text(name, "V1")
