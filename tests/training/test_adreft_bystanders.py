"""Bystanders are forgotten, nobody else is."""

import numpy as np

from roadmend.repair.adreft.rich_kernel import ATTRIBUTES, EGO, ENTER, FORECAST, GAP, MANNERS, PARTICIPANT, THEY_ENTER
from roadmend.training.adreft.bystanders import bystanders, forget


def scene():
    """A bystander, then one who is near, one who comes near, one who crosses, and the ego."""
    tokens = np.zeros((1, 5, ATTRIBUTES), dtype=np.float32)
    tokens[0, :4, PARTICIPANT] = 1.0
    tokens[0, :4, [GAP, ENTER, THEY_ENTER]] = 1.0
    tokens[0, :4, FORECAST : FORECAST + 2 * MANNERS] = 1.0
    tokens[0, 1, GAP] = 0.3
    tokens[0, 2, FORECAST + 4] = 0.9
    tokens[0, 3, ENTER] = 0.5
    tokens[0, 4, EGO] = 1.0
    return tokens


def test_who_is_a_bystander():
    assert bystanders(scene()).tolist() == [[True, False, False, False, False]]


def test_as_many_are_forgotten_as_were_asked_for():
    tokens = np.repeat(scene(), 2000, axis=0)
    mask = np.ones(tokens.shape[:2], dtype=np.bool_)
    mask[:, 3] = False
    kept = forget(tokens, mask, 0.25, np.random.default_rng(1))
    assert 0.2 < 1.0 - kept[:, 0].mean() < 0.3
    np.testing.assert_array_equal(kept[:, 1:], mask[:, 1:])
    np.testing.assert_array_equal(forget(tokens, mask, 0.0, np.random.default_rng(1)), mask)
