"""Practice: monitor and adapter learn from trials what every action is worth, all parameters together.

Fitted Q iteration (Ernst et al. 2005) on the trials: first on what the episodes came to, then on the value of the
best action some decisions later. It stands in the place of the paper's cross-entropy on weak labels (ADReFT section
3.2.1), which says "brake fully" wherever a collision is near; ReFT goes on from here as from there.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from functools import partial
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
from roadmend.training.adreft.network import AdreftNetwork, load_tensors, tensors_of
from roadmend.training.adreft.stage import StageRun
from roadmend.training.adreft.supervised import check_identity
from roadmend.training.adreft.trial_set import TrialBatch, TrialSet
from roadmend.training.optimizer_state import load_optimizer, optimizer_tensors

KIND = "adreft-practice-state"
# Of the adapter's outputs for a batch of decisions, by their indices.
Loss = Callable[[Tensor, NDArray[np.int64]], Tensor]
_JUDGED = 1024  # decisions of a batch that is only judged
_CLIP = 1.0  # largest norm of the gradient


@dataclass(frozen=True, slots=True)
class PracticeFigures:
    """What an epoch came to, means over its batches."""

    epoch: int  # from 1
    value_loss: float
    monitor_loss: float


class PracticeStage:
    """One run of the stage. It goes on from its state after an interruption."""

    _stream = 5  # of random numbers, so that stages of one seed share none

    def __init__(
        self,
        model: ModelConfiguration,
        section: PracticeSection,
        trials: TrialSet,
        run: StageRun,
        start: Mapping[str, NDArray[Any]] | None = None,
    ) -> None:
        """Prepare the stage, or load where it stood.

        Args:
            model: what to train.
            section: how.
            trials: what to learn from.
            run: its seed is that of the initial weights and of the order of the decisions.
            start: tensors of an earlier round to begin with.

        Raises:
            InputError: the file is of another run, or there is no trial.
        """
        if not len(trials):
            raise InputError("training split", "gives no trial", "give a corpus with cases in it")
        self._section, self._trials = section, trials
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
            "trials": trials.digest,
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

    def _targets(self, drawn: NDArray[np.int64]) -> Tensor:
        """What every chosen action should be worth, shape (F,); zero where it was not drawn."""
        trials = self._trials
        if self.epoch < self._section.monte_carlo_epochs:
            return torch.from_numpy(trials.total)
        following = trials.following[drawn]
        best = np.zeros(len(trials), dtype=np.float32)
        self.network.eval()
        with torch.no_grad():
            for chosen in trials.sorted_batches_of(np.unique(following[following >= 0]), _JUDGED):
                batch = trials.batch(chosen)
                _, values = self.network(self._to(batch.tokens), self._to(batch.mask), self._to(batch.action))
                best[chosen] = values.max(dim=1).values.cpu().numpy()
        ahead = np.where(following >= 0, best[following], 0.0)
        targets = np.zeros(len(trials), dtype=np.float32)
        # Every reward is a price, so no value is above zero: an estimate that is would feed upon itself.
        targets[drawn] = trials.reward[drawn] + trials.discount[drawn] * np.minimum(ahead, 0.0)
        return torch.from_numpy(targets)

    def _learn(self) -> PracticeFigures:
        """One epoch; its chance comes from the seed and its number alone."""
        trials, generator = self._trials, np.random.default_rng([self._run.seed, self._stream, self.epoch])
        drawn, loss = self._draw(generator)
        critical, judged = torch.from_numpy(trials.critical), torch.from_numpy(trials.judged)
        size, forgotten = self._section.batch, self._section.forget
        steps = math.ceil(len(drawn) / size)
        value_total, monitor_total, count = 0.0, 0.0, 0
        self.network.train()
        for chosen in trials.batches_of(drawn, size, generator):
            for group in self._optimizer.param_groups:
                group["lr"] = self._rate(self.epoch + count / steps)
            batch = trials.batch(chosen)
            mask = batch.mask if not forgotten else forget(batch.tokens, batch.mask, forgotten, generator)
            logits, outputs = self._judge(batch, mask, generator)
            value = loss(outputs, chosen)
            monitor = cross_entropy(logits, critical[chosen].to(self._run.device), judged[chosen].to(self._run.device))
            self._optimizer.zero_grad(set_to_none=True)
            (value + monitor).backward()  # type: ignore[no-untyped-call]
            torch.nn.utils.clip_grad_norm_(self.network.parameters(), _CLIP)
            self._optimizer.step()
            value_total, monitor_total = value_total + value.item(), monitor_total + monitor.item()
            count += 1
        if not math.isfinite(value_total + monitor_total):
            raise RoadmendError("the loss is no longer finite; try a lower learning rate")
        return PracticeFigures(self.epoch + 1, value_total / count, monitor_total / count)

    def _draw(self, generator: np.random.Generator) -> tuple[NDArray[np.int64], Loss]:
        """Indices of an epoch's decisions, and the loss of what the adapter says of them."""
        drawn = self._trials.draw(self._section.decisions_per_epoch, generator)
        return drawn, partial(self._loss, self._targets(drawn))

    def _loss(self, targets: Tensor, outputs: Tensor, chosen: NDArray[np.int64]) -> Tensor:
        """How far the adapter's outputs, shape (B, actions), are from what the chosen decisions should be worth."""
        counted = torch.from_numpy(self._trials.alike)[chosen].to(self._run.device, torch.float32)
        wanted = targets[chosen].to(self._run.device)[:, None].expand_as(outputs)
        apart = functional.smooth_l1_loss(outputs, wanted, reduction="none") * counted
        return (apart.sum(dim=1) / counted.sum(dim=1).clamp(min=1.0)).mean()

    def _judge(
        self, batch: TrialBatch, mask: NDArray[np.bool_], generator: np.random.Generator
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
