"""What a search found is driven again from its file and judged by records; the sums say how many."""

from roadmend.safe.contact import Part
from roadmend.safe.crash_record import CrashRecord, RecordedCollision, RecordedImpact, RecordedVehicle
from roadmend.safe.driving import CrashTestJob, CrashTestResult, Task, do
from roadmend.safe.judging import JudgedRun, judge_results, summarise_judged

from .crashes import HEAD_ON, role
from .lone import LONE, onlooker


def record(case, *collisions, heading=0.0):
    vehicles = tuple(RecordedVehicle(number, to, to) for number, to in ((1, heading), (2, heading + 180.0)))
    return CrashRecord(case, ("Straight",), vehicles, collisions, None, len(collisions))


def test_a_run_is_judged_from_its_file_by_its_own_record_and_by_others(tmp_path):
    job = CrashTestJob(Task.REPRODUCE, role(HEAD_ON, report="here"), "modular", 0, 0, 30, tmp_path, None)
    found = do(job)
    assert found.reproduced
    assert found.physical
    hit = RecordedCollision(2, 1)
    records = {"here": record("here", hit), "there": record("there", hit, heading=90.0), "same": record("same", hit)}
    unknown, nothing = (
        CrashTestResult("gone", 1, "modular", "gone.yaml"),
        CrashTestResult("here", 2, "modular", note="why"),
    )
    told = []
    judged, without, failed = judge_results([found, unknown, nothing], records, tmp_path, 1, told.append)
    assert judged.is_reproduced
    assert (judged.wrong_records, judged.wrongly_accepted) == (2, 1)
    assert judged.hardest[0] > 0.0
    assert "no record" in without.note
    assert (failed.failed, failed.note) == (None, "why")
    assert told == [1, 2, 3]


def test_a_vehicle_alone_is_held_against_others_that_crashed_alone(tmp_path):
    job = CrashTestJob(Task.REPRODUCE, onlooker(LONE["right"], "here"), "modular", 0, 0, 12, tmp_path, None)
    found = do(job)

    def alone(case, part=Part.FRONT, heading=270.0):
        vehicle = RecordedVehicle(1, heading, heading)
        return CrashRecord(case, ("Straight",), (vehicle,), (), None, 1, (RecordedImpact(1, part),))

    others = [
        alone("same"),
        alone("part", Part.LEFT),
        alone("way", heading=90.0),
        record("two", RecordedCollision(1, 2)),
    ]
    records = {each.case: each for each in (alone("here"), *others)}
    (judged,) = judge_results([found], records, tmp_path, 1, lambda _done: None)
    assert judged.is_reproduced
    assert (judged.vehicle, judged.stood) == (None, False)
    assert (judged.wrong_records, judged.wrongly_accepted) == (3, 1)
    summary = summarise_judged(["here"], ["here"], [judged])
    assert (summary.reproduced, summary.looked_on, summary.stood) == (1, 1, 0)


def test_a_report_counts_once_and_what_a_dimension_costs_is_told():
    runs = [
        JudgedRun("a", 1, "p", {}, shown=1, recorded=2, is_physical=True, wrong_records=4, wrongly_accepted=1),
        JudgedRun("a", 2, "p", {}, shown=2, recorded=2, is_physical=True),
        JudgedRun("b", 1, "p", {"parts": "x"}, is_physical=True),
        JudgedRun("c", 1, "p", {"parts": "x", "physical": "y"}, is_physical=False),
        JudgedRun("d", 1, "p", {}, shown=1, recorded=1, is_physical=True, stood=True),
        JudgedRun("e", 1, "p", note="a single vehicle"),
    ]
    found = summarise_judged(["a", "b", "c", "d", "e"], ["a", "b", "c", "d"], runs)
    assert (found.reports, found.recorded, found.run, found.reproduced, found.stood) == (5, 4, 4, 2, 1)
    assert found.names == ("a", "d")
    assert (found.but_for["parts"], found.but_for["physical"], found.but_for["who"]) == (3, 2, 2)
    assert (found.failed["parts"], found.unphysical) == (2, 1)
    assert (found.shown, found.collisions) == (3, 3)
    assert (found.wrong_records, found.wrongly_accepted) == (4, 1)
