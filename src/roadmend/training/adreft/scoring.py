"""What monitor and adapter say of many decisions, by the compiled networks, so that it is exact for what will run."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from roadmend.core.fanout import Mapper
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.weighing import DANGER
from roadmend.training.adreft.token_rows import TokenRows

Floats = NDArray[np.float64]
_Block = tuple[NDArray[Any], NDArray[np.int64], NDArray[np.float32]]  # tokens one after the other, sizes, actions

_BLOCK = 512  # decisions that are judged in one go
_CERTAIN = 1e-9  # nearer to 0 or 1 a score has no finite logit


def monitor_scores(
    model: ModelConfiguration,
    tensors: Mapping[str, NDArray[Any]],
    rows: TokenRows,
    actions: NDArray[np.float32],
    mapper: Mapper,
) -> Floats:
    """The monitor's scores of F decisions, shape (F,).

    Args:
        model: what the networks are built from.
        tensors: of the networks.
        rows: tokens of the decisions.
        actions: the policy's throttle - brake, shape (F,).
        mapper: judges blocks of them side by side.
    """
    return _said(partial(_scores, model, tensors), rows, actions, mapper)[:, 0]


def said_logits(
    model: ModelConfiguration,
    tensors: Mapping[str, NDArray[Any]],
    rows: TokenRows,
    actions: NDArray[np.float32],
    mapper: Mapper,
) -> tuple[Floats, Floats]:
    """The logits of the monitor's score and of the danger that the adapter foresees, shapes (F,); as above."""
    found = _said(partial(_scores, model, tensors, with_danger=True), rows, actions, mapper)
    scores = np.clip(found[:, 0], _CERTAIN, 1.0 - _CERTAIN)
    return np.log(scores / (1.0 - scores)), found[:, 1]


def _said(judge: Callable[[_Block], Floats], rows: TokenRows, actions: NDArray[np.float32], mapper: Mapper) -> Floats:
    order = np.arange(len(rows))
    blocks = [block for block in np.array_split(order, max(1, len(order) // _BLOCK)) if len(block)]
    sets = [
        (rows.tokens[rows.offsets[block[0]] : rows.offsets[block[-1] + 1]], rows.sizes[block], actions[block])
        for block in blocks
    ]
    return np.concatenate([np.empty((0, 2)), *mapper(judge, sets)])


def _scores(
    model: ModelConfiguration, tensors: Mapping[str, NDArray[Any]], decisions: _Block, *, with_danger: bool = False
) -> Floats:
    """Scores and logits of danger, shape (B, 2); the latter 0 where they are not asked for."""
    tokens, sizes, actions = decisions
    tokens = tokens.astype(np.float32, copy=False)
    compiled = AdreftModel(model, tensors, 0.0)
    found = np.zeros((len(sizes), 2))
    begin = 0
    for index, size in enumerate(sizes):
        state = compiled.encode(tokens[begin : begin + size])
        found[index, 0] = compiled.score(state, float(actions[index]))
        if with_danger:
            found[index, 1] = compiled.given(state)[DANGER]
        begin += size
    return found
