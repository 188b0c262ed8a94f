"""Many reports: what goes wrong with one of them leaves the others alone."""

import pytest

from roadmend.core.errors import ForeignError, InputError
from roadmend.safe.extraction import Extraction
from roadmend.safe.extraction_run import extract_reports

from .crashes import CROSSING


class Extracting:
    """Fails at one of the reports."""

    def __init__(self, error):
        self.error = error

    def extract(self, report, watch=None):
        if report.case == "b":
            raise self.error
        return Extraction(CROSSING, {}, "there is none")


@pytest.fixture
def run(tmp_path):
    paths = [tmp_path / f"{name}.txt" for name in "abc"]
    for path in paths:
        path.write_text("V1 hit V2.")
    return lambda error: list(extract_reports(paths, Extracting(error), [], tmp_path / "out", 1))


def test_a_backend_of_ones_own_that_fails_fails_for_that_report(run):
    done = {
        each.case: each.error for each in run(ForeignError("backend own:Model", "KeyError: 'lost'", "mend the class"))
    }
    assert done.keys() == {*"abc"}
    assert [done["a"], done["c"]] == [None, None]
    assert done["b"].endswith("b.txt: backend own:Model: KeyError: 'lost'; mend the class")


def test_what_every_report_needs_ends_the_run(run):
    with pytest.raises(InputError, match="not installed"):
        run(InputError("the parser", "is not installed", "install it"))
