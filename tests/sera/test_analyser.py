"""Incidents grouped into patterns, and bags into an analysis."""

import random
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from roadmend.core.errors import InputError
from roadmend.sera.analyser import EmbeddedAnalyser
from roadmend.sera.analysis import analyse, find_bags, read_incidents
from roadmend.sera.analysis_report import NOTHING, report
from roadmend.sera.incident import IncidentEgo, IncidentPlace
from roadmend.sera.pattern import Where

from .recorded import incident

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"
EMBEDDED = EmbeddedAnalyser()


def test_what_agrees_is_one_pattern_with_what_holds_for_all_of_it():
    first = incident()
    second = incident(bag="b", where=replace(first.where, weather="clear"), avoidable=None)
    other = incident(bag="c", place=IncidentPlace("before_junction", 0, "yield", 8.0))
    patterns = EMBEDDED.analyse([other, second, first])
    assert [len(pattern.evidence) for pattern in patterns] == [2, 1]
    found = patterns[0]
    assert found.where == Where(family="S3", road="intersection")  # the weather differs
    assert (found.what, found.who.participant, found.who.side) == ("COLLISION", "car", "left")
    assert found.why.manoeuvre == "straight"
    assert found.words == "collision in the intersection: the ego goes straight on, a car crosses from the left"
    assert [(each.episode, each.time, each.scenario) for each in found.evidence] == [
        ("a", 5.0, "5" * 64),
        ("b", 5.0, "5" * 64),
    ]
    assert "avoidable until 1.20 s" in found.evidence[0].note
    assert "not avoidable" in found.evidence[1].note


def test_the_order_of_the_incidents_does_not_matter():
    incidents = [
        incident(bag=f"bag {number}", ego=IncidentEgo("turning_left" if number % 3 else "standing", 1.0))
        for number in range(9)
    ]
    shuffled = random.Random(4).sample(incidents, len(incidents))
    assert EMBEDDED.analyse(incidents) == EMBEDDED.analyse(shuffled)


def test_an_intervention_is_no_outcome_and_an_incident_without_another_names_nobody():
    (found,) = EMBEDDED.analyse([incident(kind="intervention", other=None)])
    assert found.what is None
    assert (found.who.participant, found.why.hazard) == (None, None)
    assert found.words.startswith("intervention in the intersection")


def test_no_incident_is_no_pattern():
    assert EMBEDDED.analyse([]) == ()


def test_a_folder_gives_its_bags_once_each_and_none_that_is_hidden(tmp_path):
    bag = tmp_path / "deep" / "collision"
    shutil.copytree(SAMPLES / "collision", bag)
    shutil.copytree(bag, tmp_path / ".part" / "collision")
    assert find_bags([tmp_path, bag, tmp_path / "deep"]) == [bag]
    assert find_bags([bag / "collision_0.mcap"]) == [bag / "collision_0.mcap"]


@pytest.mark.parametrize(("name", "text"), [("nowhere", "there is no such bag"), ("empty", "holds no bag")])
def test_no_bag_is_an_error(tmp_path, name, text):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match=text):
        find_bags([tmp_path / name])


def test_the_sample_of_a_collision_is_read_as_it_was():
    (found,) = read_incidents(SAMPLES / "collision").incidents
    assert (found.kind, found.time, found.at_fault, found.manner) == ("collision", 27.8, True, "ran into")
    assert (found.place.kind, found.ego.manoeuvre, found.ego.action) == ("exit_lane", "exit", "driving_on")
    assert (found.other.name, found.other.kind, found.other.encounter) == ("v8", "car", "cut_in")
    assert (found.other.side, found.other.hazard) == ("left", "cut_in_and_brake")
    assert 1.0 < found.avoidable < 2.5
    assert found.repair.verdict == "no_method"


def test_the_sample_of_a_repair_shows_what_was_needed():
    found = read_incidents(SAMPLES / "repaired").incidents
    assert {(one.kind, one.other.kind) for one in found} == {("intervention", "car")}
    assert [(one.time, one.repair.frames, one.repair.verdict) for one in found] == [(25.25, 13, "needed")]


def test_a_corrupt_bag_is_named_and_the_others_go_on(tmp_path):
    shutil.copytree(SAMPLES / "collision", tmp_path / "broken")
    (file,) = (tmp_path / "broken").glob("*.mcap")
    file.write_bytes(file.read_bytes()[:5000])
    found = analyse([read_incidents(tmp_path / "broken"), read_incidents(SAMPLES / "collision")], EMBEDDED)
    assert [each.bag for each in found.unreadable] == [str(tmp_path / "broken")]
    assert "was cut short or is corrupt" in found.unreadable[0].problem
    assert len(found.patterns) == 1
    text = report(found)
    assert "1 bag read, 1 incidents, 1 patterns" in text
    assert "at 27.80 s" in text
    assert "## Not read" in text


def test_bags_without_failures_are_an_honest_empty_result():
    assert NOTHING in report(analyse([], EMBEDDED))


def test_who_cuts_in_and_brakes_cuts_in():
    other = incident().other
    hazards = ("cut_in", "cut_in_and_brake")
    both = [incident(bag=each, other=replace(other, encounter="cut_in", hazard=each)) for each in hazards]
    assert EMBEDDED.analyse(both)[0].why.hazard == "cut_in"
    assert EMBEDDED.analyse(both[1:])[0].why.hazard == "cut_in_and_brake"


def test_a_highway_is_told_by_what_leads_onto_it_or_off_it():
    highway = incident(place=IncidentPlace("highway", 0), where=Where(road="on_ramp"))
    assert EMBEDDED.analyse([highway])[0].words.startswith("collision on the highway at an on-ramp: ")
