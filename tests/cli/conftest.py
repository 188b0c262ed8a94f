"""A recorded run of the real graph, and copies of it in which something is otherwise."""

from pathlib import Path

import pytest

from roadmend.cli import output
from roadmend.nodes.graph_options import GraphOptions
from roadmend.nodes.launcher import run_graph
from roadmend.recording.reader import BagReader
from roadmend.recording.writer import BagWriter
from roadmend.world.families import sample_scenario
from roadmend.world.scenario_file import save_scenario


@pytest.fixture(autouse=True)
def quiet(monkeypatch):
    """No lines about progress, which a slow machine would put between those that a test is about."""
    monkeypatch.setattr(output, "_SILENCE", 1e6)
    monkeypatch.setattr(output, "_PAUSE", 1e6)


@pytest.fixture(scope="session")
def recorded(tmp_path_factory):
    """The bag of a run that is repaired, and what it came to."""
    folder = tmp_path_factory.mktemp("recorded")
    save_scenario(sample_scenario("S3", 3).model_copy(update={"time_limit": 8.0}), folder / "crossing.yaml")
    options = GraphOptions(
        folder / "crossing.yaml", method="predictive", bags=folder, name="run", viz=False, tuned=True
    )
    result = run_graph(options)
    return folder / "run", result.episode


@pytest.fixture
def altered(recorded, tmp_path):
    """Copies the run: ``keep`` gives a record's bytes or None to drop it, ``attach`` and ``tell`` replace what it says."""

    def copy(keep=lambda record: record.data, attach=lambda data: data, tell=lambda values: values) -> Path:
        reader = BagReader(recorded[0])
        with BagWriter(tmp_path / "altered") as writer:
            for topic in reader.topics.values():
                writer.add_topic(topic.name, topic.type_name, topic.offers)
            for record in reader.records():
                data = keep(record)
                if data is not None:
                    writer.write(record.topic, record.time_ns, data)
            for attachment in reader.attachments.values():
                data = attach(attachment.data)
                if data is not None:
                    writer.add_attachment(attachment.name, attachment.media_type, data)
            writer.add_metadata("roadmend", tell(reader.metadata["roadmend"]))
        return tmp_path / "altered"

    return copy
