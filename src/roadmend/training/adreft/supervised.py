"""The supervised stage: all parameters learn from labelled frames (ADReFT section 3.2.1, equation 7)."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
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
from roadmend.training.adreft.calibration import calibrate, monitor_quality
from roadmend.training.adreft.configuration import SupervisedSection
from roadmend.training.adreft.frames import FrameBatch, FrameSet
from roadmend.training.adreft.network import AdreftNetwork
from roadmend.training.adreft.stage import StageRun
from roadmend.training.torch_state import load_optimizer, load_tensors, optimizer_tensors, tensors_of

KIND = "adreft-supervised-state"
_JUDGED = 1024  # frames of a batch that is only judged


@dataclass(frozen=True, slots=True)
class EpochFigures:
    """What an epoch came to, on the validation frames unless said otherwise."""

    epoch: int  # from 1
    training_loss: float  # mean over the epoch's batches
    loss: float
    precision: float  # at the calibrated threshold, as are recall and F1
    recall: float
    f1: float
    accuracy: float  # share of frames with the labelled action
    threshold: float

    def worth(self, keep: str) -> float:
        """The larger, the better."""
        return {"f1": self.f1, "loss": -self.loss, "last": float(self.epoch)}[keep]


@dataclass(frozen=True, slots=True)
class SupervisedResult:
    """What the stage gives."""

    tensors: dict[str, NDArray[Any]]  # of the whole network, at the best epoch
    figures: EpochFigures | None  # of that epoch; none if there was no epoch


class SupervisedStage:
    """One run of the stage. It goes on from its state after an interruption."""

    def __init__(
        self,
        model: ModelConfiguration,
        section: SupervisedSection,
        training: FrameSet,
        validation: FrameSet,
        run: StageRun,
    ) -> None:
        """Prepare the stage, or load where it stood.

        Args:
            model: what to train.
            section: how.
            training: frames to learn from.
            validation: frames to judge by.
            run: its seed is that of the initial weights and of the order of the frames.

        Raises:
            InputError: the file is of another run, or there is nothing to learn from or to judge by.
        """
        for name, frames in (("training", training), ("validation", validation)):
            if not np.any((frames.critical > 0.5) & (frames.critical_weight > 0.0)):
                raise InputError(f"{name} split", "no frame is critical", "give a corpus with violations in it")
        self._section, self._training, self._validation = section, training, validation
        self._run = run
        torch.manual_seed(run.seed)
        self.network = AdreftNetwork(model).to(run.device)
        kind = torch.optim.AdamW if section.optimizer == "adamw" else torch.optim.Adam
        self._optimizer = kind(self.network.parameters(), lr=section.learning_rate, weight_decay=section.weight_decay)
        self._identity = {
            "code": source_digest([type(self).__module__]),
            "model": model.model_dump(mode="json"),
            "supervised": section.model_dump(mode="json"),
            "seed": run.seed,
            "device": run.device,  # the bits depend on it, and on how many share a sum
            "threads": torch.get_num_threads(),
            "training": training.digest,
            "validation": validation.digest,
        }
        self.epoch = 0  # epochs done
        self.history: list[EpochFigures] = []
        self._best: dict[str, NDArray[Any]] = tensors_of(self.network)
        self._best_figures: EpochFigures | None = None
        if run.state.exists():
            self._load()

    def run(
        self, report: Callable[[int, EpochFigures | None], None] = lambda _epoch, _figures: None
    ) -> SupervisedResult:
        """Train to the last epoch.

        Args:
            report: called after every epoch with its number, from 1, and its figures where it was validated.
        """
        section = self._section
        writer = SummaryWriter(str(self._run.log), purge_step=self.epoch + 1) if self._run.log is not None else None
        while self.epoch < section.epochs:
            loss = self._learn()
            self.epoch += 1
            figures = None
            is_last = self.epoch == section.epochs
            if self.epoch % section.validate_every == 0 or is_last:
                figures = self._judge(loss)
                self.history.append(figures)
                best = self._best_figures
                if best is None or figures.worth(section.keep) > best.worth(section.keep):
                    self._best, self._best_figures = tensors_of(self.network), figures
                if writer is not None:
                    for name, value in asdict(figures).items():
                        writer.add_scalar(f"supervised/{name}", value, self.epoch)
            if self.epoch % section.save_every == 0 or is_last:
                self._save()
            report(self.epoch, figures)
        if writer is not None:
            writer.close()
        return SupervisedResult(dict(self._best), self._best_figures)

    def _rate(self) -> float:
        section = self._section
        if section.schedule == "constant":
            return section.learning_rate
        return 0.5 * section.learning_rate * (1.0 + math.cos(math.pi * self.epoch / section.epochs))

    def _learn(self) -> float:
        """One epoch; its chance comes from the seed and its number alone, so nothing but weights need be kept."""
        section, frames = self._section, self._training
        generator = np.random.default_rng([self._run.seed, 1, self.epoch])
        chosen = frames.draw(section.frames_per_epoch or len(frames), section.critical_share, generator)
        for group in self._optimizer.param_groups:
            group["lr"] = self._rate()
        self.network.train()
        total, count = 0.0, 0
        for batch in frames.batches(chosen, section.batch, generator):
            self._optimizer.zero_grad(set_to_none=True)
            loss = self._loss(batch)[0]
            loss.backward()  # type: ignore[no-untyped-call]
            if section.clip:
                torch.nn.utils.clip_grad_norm_(self.network.parameters(), section.clip)
            self._optimizer.step()
            total, count = total + loss.item(), count + 1
        if not math.isfinite(total):
            raise RoadmendError("the loss is no longer finite; try a lower learning rate or clip the gradient")
        return total / max(1, count)

    def _loss(self, batch: FrameBatch) -> tuple[Tensor, Tensor, Tensor]:
        """The batch's loss, the monitor's logits and the adapter's values."""
        section, to = self._section, self._to
        logits, values = self.network(to(batch.tokens), to(batch.mask), to(batch.action))
        critical, weight = to(batch.critical), to(batch.critical_weight)
        weight = weight * (1.0 + (section.critical_weight - 1.0) * critical)
        monitor = functional.binary_cross_entropy_with_logits(logits, critical, weight, reduction="sum")
        adapter = functional.cross_entropy(values, to(batch.best), reduction="none") * to(batch.best_weight)
        size = len(batch.action)
        return monitor / size + section.adapter_weight * adapter.sum() / size, logits, values

    def _judge(self, training_loss: float) -> EpochFigures:
        frames = self._validation
        scores = np.zeros(len(frames), dtype=np.float64)
        loss, right = 0.0, 0
        self.network.eval()
        with torch.no_grad():
            for indices, batch in frames.sorted_batches(_JUDGED):
                batch_loss, logits, values = self._loss(batch)
                loss += batch_loss.item() * len(indices)
                scores[indices] = torch.sigmoid(logits.double()).cpu().numpy()
                right += int((values.argmax(dim=1).cpu().numpy() == batch.best).sum())
        judged = frames.critical_weight > 0.0
        critical = frames.critical[judged] > 0.5
        threshold = calibrate(scores[judged], critical, self._section.recall)
        quality = monitor_quality(scores[judged], critical, threshold)
        size = len(frames)
        return EpochFigures(
            self.epoch,
            training_loss,
            loss / size,
            quality.precision,
            quality.recall,
            quality.f1,
            right / size,
            threshold,
        )

    def _to(self, array: NDArray[Any]) -> Tensor:
        return torch.from_numpy(np.ascontiguousarray(array)).to(self._run.device)

    def _save(self) -> None:
        tensors = {
            **tensors_of(self.network, "now."),
            **{f"best.{name}": value for name, value in self._best.items()},
            **optimizer_tensors(self._optimizer, "optimizer."),
        }
        best = None if self._best_figures is None else asdict(self._best_figures)
        header = {
            "kind": KIND,
            "configuration": self._identity,
            "data_digest": self._training.digest,
            "ancestry": [],
            "metrics": {"history": [asdict(figures) for figures in self.history], "best": best},
            "epoch": self.epoch,
        }
        save_checkpoint(self._run.state, tensors, header)

    def _load(self) -> None:
        checkpoint = load_checkpoint(self._run.state, KIND)
        check_identity(self._run.state, checkpoint.header["configuration"], self._identity)
        load_tensors(self.network, checkpoint.tensors, "now.")
        load_optimizer(self._optimizer, checkpoint.tensors, "optimizer.")
        self._best = {
            name.removeprefix("best."): value for name, value in checkpoint.tensors.items() if name.startswith("best.")
        }
        metrics = checkpoint.header["metrics"]
        self.history = [EpochFigures(**entry) for entry in metrics["history"]]
        self._best_figures = None if metrics["best"] is None else EpochFigures(**metrics["best"])
        self.epoch = checkpoint.header["epoch"]


def check_identity(path: Path, kept: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    """Refuse to go on with a state of another run.

    Raises:
        InputError: naming the first difference.
    """
    plain = json.loads(json.dumps(wanted))
    for name in {**kept, **plain}:
        if kept.get(name) != plain.get(name):
            mend = "start afresh with --restart, or give what it was begun with"
            raise InputError(str(path), f"was begun with another '{name}'", mend)
