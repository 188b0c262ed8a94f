"""The loop in which monitor and adapter learn from decisions, all parameters together.

What the adapter is taught is up to the stages: values (``practice``), or collisions with and without an intervention
(``counterfactual_stage``, ``futures_stage``).
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional
from torch.utils.tensorboard import SummaryWriter

from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.source_digest import source_digest
from roadmend.networks.checkpoint import load_checkpoint, save_checkpoint
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.training.adreft.bystanders import forget
from roadmend.training.adreft.configuration import PracticeSection
from roadmend.training.adreft.decision_set import DecisionBatch, DecisionSet
from roadmend.training.adreft.network import AdreftNetwork, digest_of_tensors
from roadmend.training.adreft.stage import StageRun
from roadmend.training.adreft.supervised import check_identity
from roadmend.training.torch_state import load_optimizer, load_tensors, optimizer_tensors, tensors_of

KIND = "adreft-practice-state"
# Of the adapter's outputs for a batch of decisions, by their indices.
Loss = Callable[[Tensor, NDArray[np.int64]], Tensor]
_CLIP = 1.0  # largest norm of the gradient


@dataclass(frozen=True, slots=True)
class PracticeFigures:
    """What an epoch came to, means over its batches."""

    epoch: int  # from 1
    value_loss: float
    monitor_loss: float


class LearningStage(ABC):
    """One run of the stage. It goes on from its state after an interruption."""

    _stream = 5  # of random numbers, so that stages of one seed share none

    def __init__(
        self,
        model: ModelConfiguration,
        section: PracticeSection,
        decisions: DecisionSet,
        run: StageRun,
        start: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:
        """Prepare the stage, or load where it stood.

        Args:
            model: what to train.
            section: how.
            decisions: what to learn from.
            run: its seed is that of the initial weights and of the order of the decisions.
            start: tensors of an earlier round to begin with.

        Raises:
            InputError: the file is of another run, or there is no decision.
        """
        if not len(decisions):
            raise InputError("training split", "gives no decision to learn from", "give a corpus with cases in it")
        self._section, self._decisions = section, decisions
        self._run = run
        torch.manual_seed(run.seed)
        self.network = AdreftNetwork(model).to(run.device)
        if start is not None:
            load_tensors(self.network, start)
        self._optimizer = torch.optim.AdamW(
            self.network.parameters(), lr=section.learning_rate, weight_decay=section.weight_decay
        )
        self._identity = {
            "code": source_digest([type(self).__module__]),
            # Prices are added when the model drives: others go with the same networks.
            "model": model.model_dump(mode="json", exclude={"weighing"}),
            "practice": section.model_dump(mode="json"),
            "seed": run.seed,
            "device": run.device,  # the bits depend on it, and on how many share a sum
            "threads": torch.get_num_threads(),
            "trials": decisions.digest,
            "start": None if start is None else digest_of_tensors(start),
        }
        self.history: list[PracticeFigures] = []
        if run.state.exists():
            self._load()

    @property
    def epoch(self) -> int:
        """Epochs done."""
        return len(self.history)

    def run(self, report: Callable[[PracticeFigures], None] = lambda _figures: None) -> dict[str, NDArray[Any]]:
        """Train to the last epoch; returns the tensors of the whole network.

        Args:
            report: called after every epoch.
        """
        writer = SummaryWriter(str(self._run.log), purge_step=self.epoch + 1) if self._run.log is not None else None
        while self.epoch < self._section.epochs:
            figures = self._learn()
            self.history.append(figures)
            self._save()
            if writer is not None:
                writer.add_scalar("practice/value_loss", figures.value_loss, figures.epoch)
                writer.add_scalar("practice/monitor_loss", figures.monitor_loss, figures.epoch)
            report(figures)
        if writer is not None:
            writer.close()
        return tensors_of(self.network)

    def _learn(self) -> PracticeFigures:
        """One epoch; its chance comes from the seed and its number alone."""
        decisions, generator = self._decisions, np.random.default_rng([self._run.seed, self._stream, self.epoch])
        drawn, loss = self._draw(generator)
        size, forgotten = self._section.batch, self._section.forget
        steps = math.ceil(len(drawn) / size)
        value_total, monitor_total, count = 0.0, 0.0, 0
        self.network.train()
        for chosen in decisions.batches_of(drawn, size, generator):
            for group in self._optimizer.param_groups:
                group["lr"] = self._rate(self.epoch + count / steps)
            batch = decisions.batch(chosen)
            mask = batch.mask if not forgotten else forget(batch.tokens, batch.mask, forgotten, generator)
            logits, outputs = self._judge(batch, mask, generator)
            value = loss(outputs, chosen)
            monitor = self._monitor_loss(logits, chosen)
            self._optimizer.zero_grad(set_to_none=True)
            (value + monitor).backward()  # type: ignore[no-untyped-call]
            torch.nn.utils.clip_grad_norm_(self.network.parameters(), _CLIP)
            self._optimizer.step()
            value_total, monitor_total = value_total + value.item(), monitor_total + monitor.item()
            count += 1
        if not math.isfinite(value_total + monitor_total):
            raise RoadmendError("the loss is no longer finite; try a lower learning rate")
        return PracticeFigures(self.epoch + 1, value_total / count, monitor_total / count)

    @abstractmethod
    def _draw(self, generator: np.random.Generator) -> tuple[NDArray[np.int64], Loss]:
        """Indices of an epoch's decisions, and the loss of what the adapter says of them."""

    def _monitor_loss(self, logits: Tensor, chosen: NDArray[np.int64]) -> Tensor:
        """How far the monitor's logits, shape (B,), are from the labels of the chosen decisions."""
        decisions = self._decisions
        return cross_entropy(logits, self._to(decisions.critical[chosen]), self._to(decisions.judged[chosen]))

    def _judge(
        self, batch: DecisionBatch, mask: NDArray[np.bool_], generator: np.random.Generator
    ) -> tuple[Tensor, Tensor]:
        """What monitor and adapter say of states with some of their entries left out; ``mask`` tells who is seen."""
        state = self.network.encoder(self._to(batch.tokens), self._to(mask))
        logits = self.network.judge(self._thin(state, generator), self._to(batch.action))
        return logits, self.network.adapter(self._thin(state, generator))

    def _thin(self, state: Tensor, generator: np.random.Generator) -> Tensor:
        """Dropout (Srivastava et al. 2014) whose chance comes from the epoch's generator, so that resuming repeats it."""
        share = self._section.dropout
        if not share:
            return state
        kept = (generator.random(tuple(state.shape)) >= share).astype(np.float32) / (1.0 - share)
        return state * self._to(kept)

    def _rate(self, done: float) -> float:
        """Learning rate after ``done`` epochs: a short rise, then half a cosine."""
        section = self._section
        share = done / section.epochs
        rise = min(1.0, share / 0.05 + 0.05)
        return section.learning_rate * rise * 0.5 * (1.0 + math.cos(math.pi * min(1.0, share)))

    def _to(self, array: NDArray[Any]) -> Tensor:
        return torch.from_numpy(np.ascontiguousarray(array)).to(self._run.device)

    def _save(self) -> None:
        tensors = {**tensors_of(self.network, "now."), **optimizer_tensors(self._optimizer, "optimizer.")}
        header = {
            "kind": KIND,
            "configuration": self._identity,
            "data_digest": self._identity["trials"],
            "ancestry": [],
            "metrics": {"history": [asdict(figures) for figures in self.history]},
        }
        save_checkpoint(self._run.state, tensors, header)

    def _load(self) -> None:
        checkpoint = load_checkpoint(self._run.state, KIND)
        check_identity(self._run.state, checkpoint.header["configuration"], self._identity)
        load_tensors(self.network, checkpoint.tensors, "now.")
        load_optimizer(self._optimizer, checkpoint.tensors, "optimizer.")
        self.history = [PracticeFigures(**entry) for entry in checkpoint.header["metrics"]["history"]]


def cross_entropy(logits: Tensor, labels: Tensor, weight: Tensor) -> Tensor:
    """Mean over a batch, by weight; all of shape (B,)."""
    wrong = functional.binary_cross_entropy_with_logits(logits, labels, weight=weight, reduction="sum")
    return wrong / weight.sum().clamp(min=1.0)
