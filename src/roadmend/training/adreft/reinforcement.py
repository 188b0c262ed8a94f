"""Reinforcement fine-tuning (ReFT): a DQN of the decision adapter, all else frozen (ADReFT section 3.2.2)."""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional
from torch.utils.tensorboard import SummaryWriter

from roadmend.core.errors import InputError, RoadmendError
from roadmend.core.fanout import Mapper
from roadmend.core.source_digest import source_digest
from roadmend.networks.checkpoint import load_checkpoint, save_checkpoint
from roadmend.networks.encoder import Head
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.training.adreft.configuration import ReinforcementSection
from roadmend.training.adreft.exploring import ReplayMemory, Roll, Rolled, Transitions, explore
from roadmend.training.adreft.network import digest_of_cases, digest_of_tensors, save_model
from roadmend.training.adreft.stage import StageRun, TrainingSubject, spread
from roadmend.training.adreft.supervised import check_identity
from roadmend.training.closed_loop import EpisodeCase, Summary, evaluate_cases, summarise
from roadmend.training.torch_state import load_optimizer, load_tensors, optimizer_tensors, tensors_of

KIND = "adreft-reinforcement-state"
_ADAPTER = "adapter."


@dataclass(frozen=True, slots=True)
class RoundFigures:
    """What a round came to; NaN-free, so that it can be kept as JSON."""

    round: int  # from 1; 0 is the adapter that the stage began with
    episodes: int  # driven so far
    epsilon: float
    fixed: float  # share of the round's violations that reached their goal, 0 .. 1
    total: float  # mean sum of rewards of an episode
    loss: float  # mean of the updates
    value: float  # mean value of the chosen actions in the updates
    updates: int  # so far
    worth: float | None  # of the validation in closed loop, where there was one
    validation: dict[str, float] | None


class ReinforcementStage:
    """One run of the stage. It goes on from its state after an interruption."""

    def __init__(
        self,
        model: ModelConfiguration,
        tensors: dict[str, NDArray[Any]],
        threshold: float,
        section: ReinforcementSection,
        subject: TrainingSubject,
        run: StageRun,
        *,
        mapper: Mapper,
    ) -> None:
        """Prepare the stage, or load where it stood.

        Args:
            model: what the networks are.
            tensors: of the whole network after the supervised stage.
            threshold: lambda_safe.
            section: how to train.
            subject: the policy under repair, cases to learn from and those on which adapters are compared.
            run: its seed is that of all chance.
            mapper: runs episodes side by side; nothing depends on how many at a time.

        Raises:
            InputError: the file is of another run, or there is no case of a kind that is wanted.
        """
        self._model, self._tensors, self._threshold = model, dict(tensors), threshold
        policy, training, seed = subject.driver.policy, subject.driver.training, run.seed
        self._section, self._policy, self._run, self._mapper = section, policy, run, mapper
        self._episodes = _draw_episodes(training, section, seed)
        self._validation = spread(subject.validation, section.validation_cases)
        torch.manual_seed(seed)
        self._online = Head(model.adapter_shape).to(run.device)
        if section.start == "supervised":
            load_tensors(self._online, self._tensors, _ADAPTER)
        self._target = Head(model.adapter_shape).to(run.device)
        self._target.load_state_dict(self._online.state_dict())
        self._optimizer = torch.optim.Adam(self._online.parameters(), lr=section.learning_rate)
        self._memory = ReplayMemory(section.memory, model.encoder.hidden)
        self._identity = {
            "code": source_digest([type(self).__module__]),
            "model": model.model_dump(mode="json"),
            "reinforcement": section.model_dump(mode="json"),
            "seed": seed,
            "device": run.device,  # the bits depend on it, and on how many share a sum
            "threads": torch.get_num_threads(),
            "policy": policy,
            "threshold": threshold,
            "networks": digest_of_tensors(self._tensors),
            "training": digest_of_cases(training),
            "validation": digest_of_cases(subject.validation),
        }
        self.episode = 0  # episodes done
        self.updates = 0
        self.history: list[RoundFigures] = []
        self._best: dict[str, NDArray[Any]] = tensors_of(self._online, _ADAPTER)
        self._best_worth: float | None = None
        if run.state.exists():
            self._load()

    def run(
        self, report: Callable[[int, RoundFigures], None] = lambda _episodes, _figures: None
    ) -> dict[str, NDArray[Any]]:
        """Train to the last episode; returns the tensors of the whole network with the adapter that is kept.

        Args:
            report: called after every round with the number of episodes driven and its figures.
        """
        section = self._section
        if self.episode >= section.episodes:
            return self._result()
        writer = SummaryWriter(str(self._run.log), purge_step=self.episode) if self._run.log is not None else None
        if not self.history and section.keep == "best" and section.start == "supervised":
            self._keep_figures(
                self._validate(RoundFigures(0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, None, None)), writer, report
            )
        while self.episode < section.episodes:
            epsilon = self._epsilon()
            rolled = self._drive(epsilon)
            self.episode += len(rolled)
            loss, value = self._learn(sum(len(entry.transitions) for entry in rolled))
            violations = [entry for entry in rolled if entry.is_violation]
            number = (self.history[-1].round if self.history else 0) + 1
            figures = RoundFigures(
                number,
                self.episode,
                epsilon,
                sum(entry.outcome == "GOAL" for entry in violations) / max(1, len(violations)),
                sum(entry.total for entry in rolled) / len(rolled),
                loss,
                value,
                self.updates,
                None,
                None,
            )
            if section.keep == "best" and (number % section.validate_every == 0 or self.episode >= section.episodes):
                figures = self._validate(figures)
            self._keep_figures(figures, writer, report)
        if writer is not None:
            writer.close()
        return self._result()

    def _keep_figures(
        self, figures: RoundFigures, writer: SummaryWriter | None, report: Callable[[int, RoundFigures], None]
    ) -> None:
        self.history.append(figures)
        if writer is not None:
            plain = asdict(figures)
            validation = plain.pop("validation") or {}
            for name, number in plain.items():
                if number is not None:
                    writer.add_scalar(f"reinforcement/{name}", number, figures.episodes)
            for name, number in validation.items():
                writer.add_scalar(f"validation/{name}", number, figures.episodes)
        self._save()
        report(self.episode, figures)

    def _epsilon(self) -> float:
        section = self._section
        share = min(1.0, self.episode / (section.epsilon_share * section.episodes))
        return section.epsilon_begin + share * (section.epsilon_end - section.epsilon_begin)

    def _networks(self) -> dict[str, NDArray[Any]]:
        return {**self._tensors, **tensors_of(self._online, _ADAPTER)}

    def _drive(self, epsilon: float) -> list[Rolled]:
        """One round of episodes on the adapter as it is now."""
        section = self._section
        tensors = self._networks()
        numbers = range(self.episode, min(self.episode + section.round, section.episodes))
        rolls = [
            Roll(
                self._episodes[number],
                self._policy,
                self._model,
                tensors,
                self._threshold,
                section,
                epsilon,
                (self._run.seed, 3, number),
            )
            for number in numbers
        ]
        rolled = list(self._mapper(explore, rolls))
        for entry in rolled:
            self._memory.add(entry.transitions)
        return rolled

    def _learn(self, fresh: int) -> tuple[float, float]:
        """Updates for ``fresh`` new transitions; mean loss and mean value."""
        section = self._section
        if self._memory.added < section.warm_up or not len(self._memory):
            return 0.0, 0.0
        generator = np.random.default_rng([self._run.seed, 4, self.episode])
        losses, values = [], []
        for _ in range(round(fresh * section.updates_per_step)):
            loss, value = self._update(self._memory.sample(section.batch, generator))
            losses.append(loss)
            values.append(value)
            self.updates += 1
            if self.updates % section.target_every == 0:
                self._target.load_state_dict(self._online.state_dict())
        loss, value = float(np.mean(losses or [0.0])), float(np.mean(values or [0.0]))
        if not math.isfinite(loss):
            raise RoadmendError(
                "the adapter's loss is no longer finite; try a lower learning rate or clip the gradient"
            )
        return loss, value

    def _update(self, batch: Transitions) -> tuple[float, float]:
        """One step down the loss E[(r + gamma max_a' Q_target(s', a') - Q(s, a))^2]."""
        section, to = self._section, self._to
        after, action = to(batch.after), to(batch.action)
        with torch.no_grad():
            ahead = self._target(after)
            best = (self._online(after) if section.double else ahead).argmax(dim=1, keepdim=True)
            wanted = to(batch.reward) + to(batch.discount) * ahead.gather(1, best)[:, 0]
        value = self._online(to(batch.state)).gather(1, action[:, None])[:, 0]
        loss = functional.mse_loss(value, wanted) if section.loss == "squared" else functional.huber_loss(value, wanted)
        self._optimizer.zero_grad(set_to_none=True)
        loss.backward()  # type: ignore[no-untyped-call]
        if section.clip:
            torch.nn.utils.clip_grad_norm_(self._online.parameters(), section.clip)
        self._optimizer.step()
        return loss.item(), value.mean().item()

    def _validate(self, figures: RoundFigures) -> RoundFigures:
        """Drive the validation cases with the adapter as it is, and keep it if none was better."""
        path = self._run.state.with_name("candidate.safetensors")
        save_model(path, self._model, self._networks(), self._threshold)
        results = evaluate_cases(self._validation, self._policy, "adreft", {"model": str(path)}, mapper=self._mapper)
        path.unlink()
        summary = summarise(results)
        worth = self._worth(summary)
        if self._best_worth is None or worth > self._best_worth:
            self._best_worth, self._best = worth, tensors_of(self._online, _ADAPTER)
        return RoundFigures(**{**asdict(figures), "worth": worth, "validation": summary.as_dict()})

    def _worth(self, summary: Summary) -> float:
        section = self._section
        price = section.dose_weight * summary.dose + section.intensity_weight * summary.intensity
        return summary.delta_e - section.late_weight * summary.late - price

    def _result(self) -> dict[str, NDArray[Any]]:
        return {**self._tensors, **self._best} if self._section.keep == "best" else self._networks()

    def _to(self, array: NDArray[Any]) -> Tensor:
        return torch.from_numpy(np.ascontiguousarray(array)).to(self._run.device)

    def _save(self) -> None:
        tensors = {
            **tensors_of(self._online, "online."),
            **tensors_of(self._target, "target."),
            **{f"best.{name}": value for name, value in self._best.items()},
            **optimizer_tensors(self._optimizer, "optimizer."),
            **self._memory.tensors("memory."),
        }
        header = {
            "kind": KIND,
            "configuration": self._identity,
            "data_digest": self._identity["training"],
            "ancestry": [],
            "metrics": {"history": [asdict(figures) for figures in self.history], "best": self._best_worth},
            "episode": self.episode,
            "updates": self.updates,
            "added": self._memory.added,
        }
        save_checkpoint(self._run.state, tensors, header)

    def _load(self) -> None:
        checkpoint = load_checkpoint(self._run.state, KIND)
        header, tensors = checkpoint.header, checkpoint.tensors
        check_identity(self._run.state, header["configuration"], self._identity)
        load_tensors(self._online, tensors, "online.")
        load_tensors(self._target, tensors, "target.")
        load_optimizer(self._optimizer, tensors, "optimizer.")
        self._best = {name.removeprefix("best."): value for name, value in tensors.items() if name.startswith("best.")}
        self._memory.load(tensors, "memory.", header["added"])
        self.history = [RoundFigures(**entry) for entry in header["metrics"]["history"]]
        self._best_worth = header["metrics"]["best"]
        self.episode, self.updates = header["episode"], header["updates"]


def _draw_episodes(cases: Sequence[EpisodeCase], section: ReinforcementSection, seed: int) -> list[EpisodeCase]:
    """The case of every episode: violations and successes in their shares, each group shuffled and gone through in turn.

    Raises:
        InputError: a group that is wanted is empty.
    """
    generator = np.random.default_rng([seed, 2])
    groups = [[case for case in cases if case.is_violation is kind] for kind in (True, False)]
    for group, share, name in zip(
        groups, (section.violation_share, 1.0 - section.violation_share), ("violation", "success"), strict=True
    ):
        if not group and share > 0.0 and section.episodes:
            raise InputError(
                "training split", f"holds no {name}", "give a corpus with both, or another violation_share"
            )
    left: list[list[int]] = [[], []]
    drawn: list[EpisodeCase] = []
    for _ in range(section.episodes):
        kind = 0 if generator.random() < section.violation_share else 1
        if not left[kind]:
            left[kind] = generator.permutation(len(groups[kind])).tolist()
        drawn.append(groups[kind][left[kind].pop()])
    return drawn
