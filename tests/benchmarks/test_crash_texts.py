"""The committed texts in other registers: well-formed, and those that the reader was written on still understood."""

from pathlib import Path

import pytest

from harness.scoring import load_oracles, score
from roadmend.safe.dsl_data import dump_data
from roadmend.safe.embedded import EmbeddedExtractor
from roadmend.safe.extraction import ExtractionError
from roadmend.safe.report import load_report

TEXTS = Path(__file__).parent / "crash_texts"
LEAST = 70.0  # [%] read right in every field; the later ones, from 255 on, are harder


def test_every_text_has_its_oracle_and_the_other_way_round():
    texts = {path.stem for path in TEXTS.glob("*.txt")}
    assert texts == {*load_oracles(TEXTS)}
    assert sum(name.startswith("measured-") for name in texts) >= 60


@pytest.mark.parametrize("solver", [True, False])
def test_what_the_reader_was_written_on_is_still_understood(solver):
    paths = sorted(TEXTS.glob("developed-*.txt"))[::3]  # a third does, in a third of the time
    extractor = EmbeddedExtractor(solver=solver)
    known = load_oracles(TEXTS)
    oracles = {path.stem: known[path.stem] for path in paths}
    readings = {}
    for path in paths:
        try:
            readings[path.stem] = dump_data(extractor.extract(load_report(path)).scenario)
        except ExtractionError:
            readings[path.stem] = None
    found = score(readings, oracles, text_only=True)
    assert (found.overall >= LEAST) is solver
