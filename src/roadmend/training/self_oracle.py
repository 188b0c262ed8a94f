"""Trains the SelfOracle model: an autoencoder on frames of successful drives, and the thresholds of its errors."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from pydantic import Field
from torch.nn import functional

from roadmend.core.command import Decision
from roadmend.core.errors import InputError
from roadmend.core.fanout import Mapper
from roadmend.core.parameters import Parameters
from roadmend.core.repair import Repair
from roadmend.core.tick import Tick
from roadmend.networks.encoder import Head
from roadmend.networks.shape import HeadShape
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.repair.self_oracle import CLIP, KIND, Configuration, SelfOracleModel
from roadmend.repair.state_vector import SIZE, VERSION, state_vector
from roadmend.training.closed_loop import EpisodeCase, check_driven
from roadmend.training.device import one_thread
from roadmend.training.tuning_grid import RATES
from roadmend.world.runner import run_episode

_LEAST_SCALE = 0.05  # entries that hardly vary are not blown up
_HELD_OUT = 5  # every so many-th case is kept for the gamma fit

Vectors = NDArray[np.float32]


class SelfOracleSettings(Parameters):
    """How to train."""

    hidden: tuple[int, ...] = Field((64, 16, 64), description="hidden widths; the middle one is the bottleneck")
    epochs: int = Field(100, ge=1, le=10_000)
    batch: int = Field(256, ge=1, le=65_536, description="frames of a batch")
    learning_rate: float = Field(1e-3, gt=0.0, le=1.0)
    stride: int = Field(4, ge=1, le=100, description="every so many-th tick is a frame")
    seed: int = Field(0, ge=0)


@dataclass(frozen=True, slots=True)
class SelfOracleResult:
    """A trained model, as a checkpoint holds it."""

    tensors: dict[str, NDArray[Any]]
    configuration: Configuration
    metrics: Mapping[str, float]

    def header(self, settings: SelfOracleSettings, data_digest: str, **more: Any) -> dict[str, Any]:
        """The checkpoint's header; ``more`` stands beside the settings in the configuration."""
        configuration = {"model": self.configuration.model_dump(mode="json"), "training": settings.model_dump(), **more}
        return {
            "kind": KIND,
            "configuration": configuration,
            "data_digest": data_digest,
            "metrics": dict(self.metrics),
            "ancestry": [],
        }


def vectors_of_case(case: EpisodeCase, *, policy: str, stride: int) -> Vectors:
    """State vectors of every ``stride``-th tick while the policy drives alone, shape (F, SIZE).

    Raises:
        InputError: the scenario is unusable, or the policy drives it otherwise than the corpus says.
        SimulationError: SUMO failed.
    """
    vectors: list[Vectors] = []

    def watch(tick: Tick, decision: Decision, _repair: Repair) -> None:
        if tick.number % stride == 0:
            vectors.append(state_vector(tick.scene, decision))

    summary = run_episode(case.scenario(), make_policy(policy), make_repairer("none"), watch)
    check_driven(case, policy, summary.digest)
    return np.stack(vectors)


def gather_vectors(
    cases: Sequence[EpisodeCase],
    policy: str,
    stride: int,
    mapper: Mapper,
    report: Callable[[], None] = lambda: None,
) -> list[Vectors]:
    """State vectors of every successful case among ``cases``, in their order.

    Raises:
        InputError: no case is a success, or one cannot be driven as the corpus says.
        SimulationError: SUMO failed, or a worker process died.
    """
    successes = [case for case in cases if not case.is_violation]
    if not successes:
        raise InputError("corpus", "no case is a success", "give a corpus with successes in it")
    gathered: list[Vectors] = []
    for vectors in mapper(partial(vectors_of_case, policy=policy, stride=stride), successes):
        gathered.append(vectors)
        report()
    return gathered


def train_self_oracle(
    cases: Sequence[Vectors], settings: SelfOracleSettings, report: Callable[[int, float], None] = lambda _e, _l: None
) -> SelfOracleResult:
    """Train on the cases' vectors but for every fifth case, whose errors the gamma distribution is fitted to.

    Computes on one thread of the CPU, so the same vectors and settings give the same bits.

    Args:
        cases: state vectors by case, shape (F, SIZE) each.
        settings: how to train.
        report: called after every epoch with its number, from 1, and its mean loss.

    Raises:
        InputError: there are fewer than two cases.
    """
    if len(cases) < 2:
        raise InputError("corpus", "has fewer than two successes", "give a larger corpus")
    held_out = np.concatenate(cases[::_HELD_OUT])
    training = np.concatenate([vectors for place, vectors in enumerate(cases) if place % _HELD_OUT])
    mean = training.mean(axis=0, dtype=np.float64).astype(np.float32)
    scale = np.maximum(training.std(axis=0, dtype=np.float64), _LEAST_SCALE).astype(np.float32)
    shape = HeadShape(inputs=SIZE, hidden=settings.hidden, outputs=SIZE)
    network, loss = _fit(np.clip((training - mean) / scale, -CLIP, CLIP), shape, settings, report)
    tensors = {f"autoencoder.{name}": value.detach().numpy() for name, value in network.state_dict().items()}
    tensors |= {"mean": mean, "scale": scale}
    blank = Configuration(vector_version=VERSION, autoencoder=shape, thresholds={})
    model = SelfOracleModel(blank, tensors)
    errors = np.array([model.error(vector) for vector in held_out])
    gamma = fit_gamma(errors)
    thresholds = {f"{rate:g}": gamma_quantile(*gamma, 1.0 - rate) for rate in RATES}
    metrics = {
        "training_frames": float(len(training)),
        "held_out_frames": float(len(held_out)),
        "training_loss": loss,
        "held_out_loss": float(errors.mean()),
        "gamma_shape": gamma[0],
        "gamma_scale": gamma[1],
        "held_out_alarms_at_0.05": float((errors > thresholds["0.05"]).mean()),
    }
    return SelfOracleResult(tensors, blank.model_copy(update={"thresholds": thresholds}), metrics)


@one_thread()
def _fit(
    inputs: Vectors, shape: HeadShape, settings: SelfOracleSettings, report: Callable[[int, float], None]
) -> tuple[Head, float]:
    """The trained network and the mean loss of the last epoch."""
    generator = torch.Generator().manual_seed(settings.seed)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(settings.seed)
        network = Head(shape)
    frames = torch.from_numpy(inputs.astype(np.float32))
    optimizer = torch.optim.Adam(network.parameters(), lr=settings.learning_rate)
    loss = 0.0
    for epoch in range(1, settings.epochs + 1):
        total = 0.0
        order = torch.randperm(len(frames), generator=generator)
        for begin in range(0, len(frames), settings.batch):
            batch = frames[order[begin : begin + settings.batch]]
            optimizer.zero_grad()
            error = functional.mse_loss(network(batch), batch)
            error.backward()  # type: ignore[no-untyped-call]
            optimizer.step()
            total += float(error.detach()) * len(batch)
        loss = total / len(frames)
        report(epoch, loss)
    return network, loss


def fit_gamma(values: NDArray[np.float64]) -> tuple[float, float]:
    """Shape and scale of the gamma distribution of greatest likelihood, its location being 0.

    Raises:
        InputError: the values are not all above 0, or all alike.
    """
    spread = float(np.log(values.mean()) - np.log(values).mean()) if (values > 0.0).all() else 0.0
    if not spread > 1e-12:
        raise InputError("reconstruction errors", "have no gamma distribution", "give a larger corpus")
    shape = (3.0 - spread + ((spread - 3.0) ** 2 + 24.0 * spread) ** 0.5) / (12.0 * spread)  # Minka 2002: first guess
    for _ in range(50):
        point = torch.tensor(shape, dtype=torch.float64)
        slope = 1.0 / shape - float(torch.special.polygamma(1, point))
        step = (np.log(shape) - float(torch.special.digamma(point)) - spread) / slope
        shape = max(0.5 * shape, shape - step)
        if abs(step) < 1e-12 * shape:
            break
    return float(shape), float(values.mean() / shape)


def gamma_quantile(shape: float, scale: float, probability: float) -> float:
    """The value below which a gamma-distributed number lies with a probability in (0, 1), by bisection."""

    def below(value: float) -> float:
        point = torch.tensor([shape, value / scale], dtype=torch.float64)
        return float(torch.special.gammainc(point[0], point[1]))

    low, high = 0.0, shape * scale
    while below(high) < probability:
        high *= 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        if middle in {low, high}:
            break
        low, high = (middle, high) if below(middle) < probability else (low, middle)
    return high
