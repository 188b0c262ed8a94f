"""What a bag tells about the run in it."""

import hashlib

import pytest

from roadmend.core.errors import InputError
from roadmend.recording.layout import RECORD
from roadmend.recording.reader import BagReader
from roadmend.recording.recorded_run import recorded_scenario
from roadmend.recording.writer import BagWriter
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import dump_scenario


@pytest.fixture
def bag(tmp_path):
    """A bag that carries a scenario and says that one with this digest was driven."""

    def write(content, digest):
        with BagWriter(tmp_path / "bag") as writer:
            writer.add_metadata(RECORD, {"scenario_file": "one.yaml", "scenario_sha256": digest})
            writer.add_attachment("one.yaml", "application/yaml", content)
        return BagReader(tmp_path / "bag")

    return write


def test_the_scenario_that_was_driven_is_told(bag):
    content = dump_scenario(sample_scenario("S3", 3)).encode()
    assert recorded_scenario(bag(content, hashlib.sha256(content).hexdigest())) == sample_scenario("S3", 3)


def test_a_bag_that_tells_no_digest_is_taken_at_its_word(bag):
    assert recorded_scenario(bag(dump_scenario(sample_scenario("S3", 3)).encode(), "")) == sample_scenario("S3", 3)


def test_another_scenario_than_was_driven_is_refused(bag):
    driven, other = (dump_scenario(sample_scenario("S3", seed)).encode() for seed in (3, 4))
    with pytest.raises(InputError, match=r"one\.yaml: is not the scenario that was driven: it was altered"):
        recorded_scenario(bag(other, hashlib.sha256(driven).hexdigest()))
