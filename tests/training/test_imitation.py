"""Learning to drive by imitation, with a tiny budget."""

import json

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import load_checkpoint, save_checkpoint
from roadmend.policies.neural import NeuralPolicy
from roadmend.policies.neural_kinds import KINDS
from roadmend.policies.neural_tokens import COLUMNS
from roadmend.training import dagger
from roadmend.training.adreft.random_case import FIRST_SEED
from roadmend.training.dagger import Training
from roadmend.training.demonstrations import gather, ordinary_lesson
from roadmend.training.imitation import NeuralNetwork, batches, fit, losses_of, measure, split, two_hot
from roadmend.training.imitation_configuration import (
    LAST_SEED,
    ImitationConfiguration,
    Round,
    read_imitation_configuration,
)
from roadmend.training.samples import UNASKED, Samples, load_samples, samples_digest

torch.set_num_threads(1)  # as Training does; more threads wait for each other on a busy machine
CPU = torch.device("cpu")
TINY = ImitationConfiguration(
    families=("S2", "S5"),
    every=10,
    hidden=16,
    feed_forward=32,
    head=(16,),
    batch=16,
    first_seed=240_000,
    held_out=0.5,
    rounds=(Round(episodes=1, epochs=6, learning_rate=3e-3), Round(episodes=1, epochs=2, expert_share=0.3)),
)
BINS = KINDS["neural"].bins


def network_of(configuration: ImitationConfiguration) -> NeuralNetwork:
    return NeuralNetwork(configuration.kind, configuration.encoder_shape, configuration.head_shape)


@pytest.fixture(scope="module")
def samples() -> Samples:
    return Samples.join([gather(ordinary_lesson(family, 240_100, None, 1.0, 0.5, 5)) for family in ("S3", "S5")])


@settings(deadline=None)
@given(st.lists(st.floats(-1.0, 1.0), min_size=1, max_size=20))
def test_two_hot_weights_have_the_action_as_their_mean(actions):
    weights = two_hot(torch.tensor(actions), BINS)
    places = torch.linspace(-1.0, 1.0, BINS)
    assert torch.allclose(weights.sum(1), torch.ones(len(actions)), atol=1e-5)
    assert torch.allclose(weights @ places, torch.tensor(actions), atol=1e-5)
    assert bool(((weights > 0.0).sum(1) <= 2).all())


def test_a_head_that_cannot_be_built_is_refused(tmp_path):
    path = tmp_path / "settings.yaml"
    path.write_text("head: [0]\n")
    with pytest.raises(InputError, match=r"field head\[0\]"):
        read_imitation_configuration(path)


def test_gathering_repeats_bit_for_bit_and_is_sound(samples):
    again = Samples.join([gather(ordinary_lesson(family, 240_100, None, 1.0, 0.5, 5)) for family in ("S3", "S5")])
    assert samples_digest(again) == samples_digest(samples)
    assert len(samples.outcomes) == 2
    assert samples.tokens.shape == (samples.counts.sum(), COLUMNS)
    assert np.abs(samples.actions).max() <= 1.0
    assert set(samples.changes.tolist()) <= {UNASKED, 0, 1}
    assert 1 in samples.changes


def test_batches_hold_every_row_once_with_its_own_tokens(samples):
    rows = np.arange(len(samples))
    tokens = counts = 0
    for batch in batches(samples, rows, 32, np.random.default_rng(1), CPU):
        counts += len(batch.actions)
        tokens += int(batch.mask.sum())
        assert not bool(batch.tokens[~batch.mask].any())
        assert bool((batch.tokens[:, 0, 0] == 1.0).all())
    assert (counts, tokens) == (len(samples), len(samples.tokens))


def test_the_loss_falls_and_the_error_with_it(samples):
    torch.manual_seed(1)
    network = network_of(TINY)
    rows = np.arange(len(samples))
    before = measure(network, samples, rows, 64, CPU)
    fit(network, samples, TINY, Round(epochs=25, learning_rate=3e-3), 1, CPU, lambda *_: None)
    after = measure(network, samples, rows, 64, CPU)
    assert after.action < 0.8 * before.action
    assert after.error < 0.8 * before.error


@pytest.mark.parametrize("held_out", [0.05, 0.1, 0.2, 0.5])
@pytest.mark.parametrize("families", [1, 2, 5])
def test_of_every_family_the_share_that_was_asked_for_is_held_out(held_out, families):
    seeds = 40
    total = seeds * families
    samples = Samples(
        np.zeros((total, COLUMNS), dtype=np.float16),
        np.ones(total, dtype=np.int16),
        np.zeros(total, dtype=np.float32),
        np.full(total, UNASKED, dtype=np.int8),
        np.arange(total, dtype=np.int32),
        ("GOAL",) * total,
    )
    learned, held = split(samples, held_out, families)
    assert sorted([*learned, *held]) == [*range(total)]
    assert np.bincount(held % families, minlength=families).tolist() == [round(held_out * seeds)] * families


def test_where_no_episode_is_held_out_no_loss_is_told(tmp_path):
    said = []
    few = TINY.model_copy(update={"held_out": 0.05, "rounds": TINY.rounds[:1]})
    model = Training(few, 3, tmp_path / "few", 1, "cpu", "test", lambda *told: said.append(told)).run()
    assert load_checkpoint(model, "neural").header["metrics"]["held_out"] is None
    what, done, total, how = said[-1]
    assert (what, done, how) == ("round 0: learning", total, "no episode held out")
    assert {name for name, *_ in said} == {"round 0: driving", "round 0: learning"}  # of each a bar, and no more


def test_nothing_is_learned_about_lane_changes_that_nobody_asked_for(samples):
    torch.manual_seed(1)
    network = network_of(TINY)
    unasked = np.flatnonzero(samples.changes == UNASKED)[:16]
    batch = next(batches(samples, unasked, 16, None, CPU))
    assert float(losses_of(network, batch)[1]) == 0.0


def test_an_interrupted_training_goes_on_to_the_same_model(tmp_path):
    def train(folder, rounds):
        configuration = TINY.model_copy(update={"rounds": TINY.rounds[:rounds]})
        return Training(configuration, 3, tmp_path / folder, 1, "cpu", "test", lambda *_: None).run()

    whole = train("whole", 2)
    train("parts", 1)
    resumed = train("parts", 2)
    assert resumed.read_bytes() == whole.read_bytes()
    header = load_checkpoint(whole, "neural").header
    assert header["ancestry"] == [load_checkpoint(tmp_path / "whole" / "round-0.safetensors").digest]
    assert list((tmp_path / "whole" / "tensorboard").rglob("events*"))
    assert NeuralPolicy(whole).model_digest == load_checkpoint(whole).digest
    with pytest.raises(InputError, match="other settings"):
        Training(TINY, 4, tmp_path / "whole", 1, "cpu", "test", lambda *_: None).run()


def test_samples_of_other_scenarios_are_not_gone_on_with(tmp_path, monkeypatch):
    def train():
        return Training(TINY.model_copy(update={"rounds": TINY.rounds[:1]}), 3, tmp_path, 1, "cpu", "", lambda *_: None)

    train().run()
    (tmp_path / "round-0.safetensors").unlink()
    other = dagger.ordinary_lesson
    monkeypatch.setattr(dagger, "ordinary_lesson", lambda family, seed, *rest: other(family, seed + 1, *rest))
    with pytest.raises(InputError, match="other settings"):  # as of a family whose code has changed
        train().run()


def test_a_model_tells_where_it_was_trained_and_one_that_does_not_is_gone_on_with(tmp_path):
    few = TINY.model_copy(update={"rounds": TINY.rounds[:1]})
    path = Training(few, 3, tmp_path, 1, "cpu", "", lambda *_: None).run()
    checkpoint = load_checkpoint(path)
    made = checkpoint.header["configuration"]["training"]
    assert made.pop("device") == "cpu"
    save_checkpoint(path, checkpoint.tensors, checkpoint.header)
    assert Training(few, 3, tmp_path, 1, "cpu", "", lambda *_: None).run() == path


def test_no_seed_reaches_the_scenarios_that_adreft_draws():
    most = ImitationConfiguration(first_seed=900_000, rounds=(Round(episodes=900),) * 50)
    assert most.seeds(49, LAST_SEED)[-1] < FIRST_SEED <= most.seeds(49, LAST_SEED + 1)[-1]


def test_damaged_samples_are_refused(tmp_path):
    path = tmp_path / "round-0.npz"
    path.write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(InputError, match="round-0"):
        load_samples(path, json.dumps({}))


def test_the_shipped_configuration_is_valid_and_typing_errors_are_named(tmp_path, monkeypatch):
    assert ImitationConfiguration(rounds=(Round(),))
    path = tmp_path / "policy.yaml"
    path.write_text("hiden: 64\n")
    with pytest.raises(InputError, match="hiden"):
        read_imitation_configuration(path)
    path.write_text("families: [S9]\n")
    with pytest.raises(InputError, match="S9"):
        read_imitation_configuration(path)
