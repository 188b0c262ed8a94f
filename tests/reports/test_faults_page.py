"""The page of a campaign: its tables, every run beside the undisturbed one, and what is not as it should be."""

import dataclasses

from roadmend.faults.campaign import FaultTrial
from roadmend.faults.evidence import Evidence
from roadmend.faults.fault import TopicFault
from roadmend.faults.trial import Disturbed
from roadmend.faults.verdict import campaign_rows, judge, table
from roadmend.reports.faults_page import write_page

MADE = {
    "command": "./roadmend faults",
    "commit": "0" * 40,
    "dirty": False,
    "machine": {"processor": "p", "cores": 2, "python": "3"},
}
FAULT = TopicFault(name="no <number>", topic="policy/command", distortion="nan", declared="INVALID_COMMAND")
BARE = Disturbed(True, 0, "GOAL", 3.25, False, False, (), True, False, Evidence(100, 0), ())
SEEN = Evidence(100, 2, is_declared=True, silence=1.0, to_state=0.05, to_standstill=1.5, in_diagnostics=True)
RUN = Disturbed(True, 0, "TIMEOUT", 1.75, True, False, (), True, False, SEEN, ())
FILE_ROW = {"fault": "bag: cut", "faults": ["hung"]}


def page(folder, *runs, file_rows=()):
    judged = judge(runs)
    files = [["file"], *([row["fault"]] for row in file_rows)] if file_rows else []
    return write_page(folder, "Faults", (table(campaign_rows(judged)), files), judged, file_rows, MADE).read_text()


def test_every_run_stands_beside_the_undisturbed_one_with_where_it_was_reported(tmp_path):
    text = page(tmp_path, (FaultTrial(None, "lockstep", 1.0, 0), BARE), (FaultTrial(FAULT, "lockstep", 1.0, 0), RUN))
    for words in ("no &lt;number&gt;", "TIMEOUT", "GOAL", "3.25", "1.75", "0.05", "1.50", "./roadmend faults"):
        assert words in text
    assert "standard error, bag, diagnostics" in text
    assert "Not as it should be" not in text
    assert "Damaged files" not in text


def test_what_is_not_as_it_should_be_comes_first(tmp_path):
    hung = Disturbed(True, None, "", None, False, False, (), True, False, SEEN, ())
    text = page(tmp_path, (FaultTrial(FAULT, "realtime", 2.0, 3), hung), file_rows=[FILE_ROW])
    assert "no &lt;number&gt;, realtime x 2, seed 3: hung, not reported" in text
    assert "bag: cut: hung" in text
    assert text.index("Not as it should be") < text.index("In the running graph")


def test_a_run_whose_fault_came_too_late_is_told_only_where_something_is_wrong_with_it(tmp_path):
    late = dataclasses.replace(RUN, injected=False, distance=9.87)
    trial = FaultTrial(FAULT, "lockstep", 1.0, 0)
    assert "9.87" not in page(tmp_path, (trial, late))
    assert "seed 0: hung" in page(tmp_path, (trial, dataclasses.replace(late, exit_code=None)))
