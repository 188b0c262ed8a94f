"""Frames: gathered once, whoever gathers them, and batches that hold each of them whole."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.training.adreft import gathering
from roadmend.training.adreft.case_frames import CaseFrames
from roadmend.training.adreft.frames import FrameSet
from roadmend.training.adreft.gathering import Recipe, gather_frames
from roadmend.training.adreft.labels import make_scheme
from roadmend.training.closed_loop import evaluate_cases

from .cases import Drawn, OnMap

CASES = [Drawn("S5", 3), Drawn("S4", 1)]
RECIPE = Recipe("modular", "paper", 5)


def content(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_what_is_gathered_is_the_episode(tmp_path):
    frames = gather_frames(CASES[:1], RECIPE, tmp_path, map)[0]
    result = evaluate_cases(CASES[:1], "modular", "none")[0].episode
    assert (frames.name, frames.family, frames.outcome) == ("S5-3", "S5", result.outcome.name)
    assert len(frames) == -(-result.ticks // 5)
    np.testing.assert_allclose(frames.time, 0.25 * np.arange(len(frames)))
    assert frames.end == pytest.approx(0.05 * result.ticks)
    assert frames.tokens.shape == (frames.counts.sum(), 6)
    assert frames.distance.min() >= result.min_distance
    assert np.abs(frames.action).max() <= 1.0


def test_neither_workers_nor_interruptions_change_what_is_gathered(tmp_path, monkeypatch):
    with fan_out(2) as mapper:
        gather_frames(CASES, RECIPE, tmp_path / "two", mapper)
    gather_frames(CASES[:1], RECIPE, tmp_path / "one", map)
    gather_frames(CASES, RECIPE, tmp_path / "one", map)
    assert content(tmp_path / "one") == content(tmp_path / "two")
    monkeypatch.setattr(gathering, "run_episode", lambda *_: pytest.fail("drove again"))
    assert [frames.name for frames in gather_frames(CASES, RECIPE, tmp_path / "one", map)] == ["S5-3", "S4-1"]


def test_a_damaged_file_is_made_anew(tmp_path):
    gather_frames(CASES[:1], RECIPE, tmp_path, map)
    [(name, whole)] = content(tmp_path).items()
    (tmp_path / name).write_bytes(whole[:100])
    gather_frames(CASES[:1], RECIPE, tmp_path, map)
    assert content(tmp_path) == {name: whole}


def test_recipes_that_differ_have_different_files():
    others = [replace(RECIPE, tokenizer="rich"), replace(RECIPE, stride=4), replace(RECIPE, policy="neural")]
    cases = [*CASES, Drawn("S5", 3, digest="d")]
    keys = {key for recipe in (RECIPE, *others) for key in recipe.keys(cases)}
    assert len(keys) == 12


def test_a_map_that_has_changed_makes_another_file(tmp_path):
    path, keys = tmp_path / "own.net.xml", set()
    for content in ("<net/>", "<net></net>"):
        path.write_text(content)
        keys |= {*RECIPE.keys([OnMap("S5", 3, path=path)])}
    assert len(keys) == 2


def test_a_case_that_is_driven_otherwise_is_refused(tmp_path):
    with pytest.raises(InputError, match=r"case S5-3: 'modular' does not drive it as the corpus says; verify"):
        gather_frames([Drawn("S5", 3, digest="feed")], RECIPE, tmp_path, map)
    assert content(tmp_path) == {}


def made_up(seed, episodes=3):
    """A frame set of made-up cases in which every token tells which frame it belongs to."""
    numbers = np.random.default_rng(seed)
    cases, begin = [], 0
    for _ in range(episodes):
        count = int(numbers.integers(1, 30))
        sizes = numbers.integers(0, 9, count).astype(np.int32)
        tokens = np.repeat(np.arange(begin, begin + count), sizes)[:, None].astype(np.float32) + np.zeros((1, 6), "f4")
        distance = numbers.uniform(0.0, 4.0, count)
        time = 0.05 * np.arange(count)
        cases.append(
            CaseFrames(
                "c", "S1", "GOAL", 9.0, time, np.arange(begin, begin + count, dtype="f4"), distance, sizes, tokens
            )
        )
        begin += count
    labels = [make_scheme("weak").label(None, frames) for frames in cases]
    return FrameSet.join(cases, labels, 6)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), size=st.integers(1, 9))
def test_batches_hold_every_frame_whole(seed, size):
    frames = made_up(seed)
    seen = []
    generator = np.random.default_rng(seed)
    chosen = frames.draw(len(frames), None, generator)
    for batch in frames.batches(chosen, size, generator):
        for row, frame in enumerate(batch.action.astype(int)):
            assert batch.mask[row].sum() == frames.sizes[frame]
            assert (batch.tokens[row][batch.mask[row]] == frame).all()
            assert (batch.tokens[row][~batch.mask[row]] == 0.0).all()
            assert batch.critical[row] == frames.critical[frame]
            seen.append(frame)
    assert sorted(seen) == list(range(len(frames)))
    judged = np.concatenate([indices for indices, _ in frames.sorted_batches(size)])
    assert sorted(judged.tolist()) == list(range(len(frames)))


def test_a_balanced_epoch_has_its_share_of_critical_frames():
    frames = made_up(1, episodes=8)
    is_critical = frames.critical > 0.5
    assert 0.05 < is_critical.mean() < 0.4
    chosen = frames.draw(100, 0.5, np.random.default_rng(0))
    assert len(chosen) == 100
    assert is_critical[chosen].sum() == 50
    counts = np.bincount(chosen, minlength=len(frames))
    assert np.ptp(counts[is_critical]) <= 1
    assert (frames.draw(100, 0.5, np.random.default_rng(0)) == chosen).all()
    assert (frames.draw(100, 0.5, np.random.default_rng(1)) != chosen).any()


def test_the_digest_tells_any_difference():
    frames = made_up(5)
    assert frames.digest == made_up(5).digest
    changed = frames.critical.copy()
    changed[0] = 1.0 - changed[0]
    assert replace(frames, critical=changed).digest != frames.digest
