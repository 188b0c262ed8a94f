"""The committed texts in other registers: well-formed, and those that the reader was written on still understood."""

from pathlib import Path

import pytest

from harness.scoring import load_oracles, score
from roadmend.safe.dsl_data import dump_data
from roadmend.safe.embedded import EmbeddedExtractor
from roadmend.safe.extraction import ExtractionError
from roadmend.safe.report import load_report
from roadmend.safe.trained.trained_claims import trained_claims

TEXTS = Path(__file__).parent / "crash_texts"
LEAST = {trained_claims: 88.0, None: 70.0}  # [%] read right in every field; the later ones, from 255 on, are harder


def test_every_text_has_its_oracle_and_the_other_way_round():
    texts = {path.stem for path in TEXTS.glob("*.txt")}
    assert texts == {*load_oracles(TEXTS)}
    assert sum(name.startswith("measured-") for name in texts) >= 60


@pytest.mark.parametrize("read_text", [trained_claims, None])
def test_what_the_reader_was_written_on_is_still_understood_and_best_with_a_solver(read_text):
    paths = sorted(TEXTS.glob("developed-*.txt"))[::3]  # a third does, in a third of the time
    known = load_oracles(TEXTS)
    oracles = {path.stem: known[path.stem] for path in paths}
    with_solver, without = (
        score(
            {path.stem: _read(path, EmbeddedExtractor(read_text=read_text, solver=solver)) for path in paths},
            oracles,
            text_only=True,
        )
        for solver in (True, False)
    )
    assert with_solver.overall >= LEAST[read_text]
    assert without.overall < with_solver.overall


def _read(path, extractor):
    try:
        return dump_data(extractor.extract(load_report(path)).scenario)
    except ExtractionError:
        return None
