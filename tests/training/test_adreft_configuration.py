"""The configuration of the training: its files, its ranges, and what it refuses."""

import re
from pathlib import Path

import pytest
import yaml

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.training.adreft.configuration import TrainingConfiguration, read_training_configuration

FOLDER = Path(__file__).parents[2] / "config" / "training"
SECTIONS = ("model", "frames", "supervised", "practice", "futures", "rollouts", "reinforcement")


def names(content, section):
    return set(content[section]) if section else set(content)


@pytest.mark.parametrize("name", ["adreft", "adreft-futures", "adreft-paper"])
def test_the_files_name_every_setting(name):
    content = yaml.safe_load((FOLDER / f"{name}.yaml").read_text())
    read = read_training_configuration(FOLDER / f"{name}.yaml")
    for section in ("", *SECTIONS):
        model = getattr(read, section) if section else read
        assert names(content, section) == set(type(model).model_fields)
    read.model.configuration()


def test_the_papers_file_holds_the_papers_values():
    read = read_training_configuration(FOLDER / "adreft-paper.yaml")
    assert read.model.tokenizer == "paper"
    assert read.frames.labels == "weak"
    assert (read.supervised.epochs, read.supervised.learning_rate, read.supervised.recall) == (200, 1e-4, 0.95)
    reft = read.reinforcement
    assert (reft.episodes, reft.memory, reft.learning_rate, reft.violation) == (300, 5000, 1e-4, -10.0)
    assert reft.step_reward
    assert (reft.timeout, reft.goal, reft.dose) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("section", SECTIONS)
def test_every_setting_has_a_meaning_and_a_range(section):
    model = TrainingConfiguration.model_fields[section].annotation
    assert issubclass(model, Parameters)
    for name, info in model.model_fields.items():
        assert info.description, name
        if info.annotation in (int, float):
            kinds = {type(bound).__name__ for bound in info.metadata}
            assert kinds & {"Ge", "Gt"}, name
            assert kinds & {"Le", "Lt"}, name


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("supervised: {epoch: 3}", "field supervised.epoch is unknown, did you mean epochs?"),
        ("reinforcement: {gamma: 1.5}", "field reinforcement.gamma"),
        ("model: {monitor: [0]}", "field model.monitor"),
        ("practice: {forget: 0.3}", "practice.forget: only rich tokens"),
        ("model: [", "broken YAML"),
        ("supervised: {learning_rate: .nan}", "field supervised.learning_rate"),
    ],
)
def test_a_bad_file_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "bad.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=re.escape(words)) as caught:
        read_training_configuration(path)
    assert "\n" not in str(caught.value)


def test_what_cannot_be_built_is_refused(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text("model: {hidden: 10, heads: 4}")
    with pytest.raises(InputError, match="cannot share"):
        read_training_configuration(path).model.configuration()
    path.write_text("model: {pressing: 0.15}")
    with pytest.raises(InputError, match="needs a model with a need monitor"):
        read_training_configuration(path).model.configuration()
    path.write_text("model: {tokenizer: words}")
    with pytest.raises(InputError, match="no 'words'"):
        read_training_configuration(path).model.configuration()
    with pytest.raises(InputError, match="no such file"):
        read_training_configuration(tmp_path / "none.yaml")
