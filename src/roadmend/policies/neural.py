"""The end-to-end neural driving policies: tokens in, throttle and brake out, no rule behind them."""

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from roadmend.core import portable_math
from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.core.settings import check_parameters
from roadmend.networks.checkpoint import Checkpoint, find_model, load_checkpoint
from roadmend.networks.compiled_encoder import CompiledHead
from roadmend.policies.neural_kinds import KINDS, shapes_of
from roadmend.policies.neural_observer import Observer
from roadmend.policies.neural_tokens import may_change

_AROUND = 2  # bins to either side of the most probable one that the action is the mean over
_STOP = Decision(Command(0.0, 0.6), Trajectory.empty())  # where the ego's own state is unusable


class NeuralParameters(Parameters):
    """What a neural policy is set to."""

    model: str = Field("neural", min_length=1, description="a shipped model's name, or a model file's path")

    @classmethod
    def of(cls, kind: str, values: Mapping[str, Any] | None = None) -> Self:
        """Those of a kind, whose model ships under the kind's name; ``values`` replace the defaults.

        Raises:
            InputError: a name is unknown, or a value cannot be used.
        """
        return check_parameters({"model": kind, **(values or {})}, cls, f"policy.{kind}")

    @property
    def path(self) -> Path:
        """The model's file.

        Raises:
            InputError: there is none.
        """
        return find_model(self.model)


@cache
def _load(path: Path, _modified: int) -> Checkpoint:
    return load_checkpoint(path)


def load_model(path: Path, kind: str | None = None) -> Checkpoint:
    """A model of a neural policy, read and checked; once for as long as the file stays as it is.

    Raises:
        InputError: the file is missing, damaged, of another kind than ``kind`` or any, or was trained on other tokens.
    """
    try:
        modified = path.stat().st_mtime_ns
    except OSError:
        modified = 0  # reading it says what is wrong
    checkpoint = _load(path, modified)
    found = checkpoint.header["kind"]
    if not isinstance(found, str) or found not in KINDS or kind not in (None, found):
        wanted = f"one of the kind {kind!r}" if kind is not None else "a neural policy's"
        raise InputError(str(path), f"is a model of the kind {found!r}", f"give {wanted}")
    shapes_of(checkpoint, path)
    return checkpoint


def action_of(logits: NDArray[np.float32]) -> float:
    """The action in [-1, 1] that the logits of bins stand for: the mean over the most probable bin and its neighbours."""
    best = int(np.argmax(logits))
    low, high = max(best - _AROUND, 0), min(best + _AROUND + 1, len(logits))
    weights = portable_math.exp(logits[low:high].astype(np.float64) - float(logits[best]))
    places = np.arange(low, high) * (2.0 / (len(logits) - 1)) - 1.0
    return float(np.sum(weights * places) / np.sum(weights))


class NeuralPolicy:
    """A network over the tokens of the scene that was trained to imitate the privileged expert (DAgger).

    The network decides throttle, brake and the moment of the lane change alone; the only rule is that the flag of the
    lane change is not raised outside the route's window, where it would have no effect.
    """

    def __init__(self, model: Path, kind: str | None = None) -> None:
        """Load a model, of the ``kind`` wanted or of any.

        Raises:
            InputError: the file is missing, damaged or of another kind, was trained on other tokens, or its tensors
                are missing, of other shapes or not finite.
        """
        checkpoint = load_model(model, kind)
        self.name = str(checkpoint.header["kind"])
        self.model_digest = checkpoint.digest
        encoder, head = shapes_of(checkpoint, model)
        self._bins = KINDS[self.name].bins
        try:
            self._encoder = KINDS[self.name].compiled(encoder, checkpoint.tensors)
            self._head = CompiledHead(head, checkpoint.tensors, "head.")
        except ValueError as error:
            raise InputError(str(model), f"its tensors are not its shapes' ({error})", "give another file") from None
        self.observer = Observer()

    def reset(self, route: Route) -> None:
        """Begin an episode on ``route``; all memory of earlier ones is dropped."""
        self.observer.reset(route)

    def decide(self, tokens: NDArray[np.float32]) -> Command:
        """The network's answer to the tokens of a scene, shape (N, COLUMNS)."""
        outputs: NDArray[Any] = self._head.apply(self._encoder.encode(tokens))
        change = bool(outputs[-1] > 0.0) and may_change(tokens)
        action = action_of(outputs[:-1]) if self._bins else min(max(float(outputs[0]), -1.0), 1.0)
        return Command.from_action(action, change_lane=change)

    def step(self, scene: Scene) -> Decision:
        """Decide for one tick; brakes where the ego's own state is unusable or no route has come yet."""
        tokens = self.observer.observe(scene)
        if tokens is None:
            return _STOP
        command = self.decide(tokens)
        if command.change_lane:
            self.observer.begin_change()
        word = "change" if command.change_lane else "brake" if command.brake > 0.05 else "drive"
        return Decision(command, self.observer.trajectory(command.action, word))
