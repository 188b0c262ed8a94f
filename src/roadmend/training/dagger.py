"""Rounds of gathering and fitting: behaviour cloning of the expert, then DAgger (Ross, Gordon, Bagnell 2011).

A folder holds, of every round, the samples (round-K.npz) and the model after it (round-K.safetensors). What is there
is not made again, and everything follows from the configuration and the seed, so an interrupted training goes on to
the same result.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import torch
from torch.utils.tensorboard import SummaryWriter

from roadmend.core.errors import InputError
from roadmend.core.fanout import fan_out
from roadmend.core.journal import entry_key
from roadmend.networks.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from roadmend.training.demonstrations import gather, ordinary_lesson
from roadmend.training.imitation import Losses, NeuralNetwork, fit, load_network
from roadmend.training.imitation_configuration import ImitationConfiguration
from roadmend.training.samples import Samples, load_samples, samples_digest, save_samples
from roadmend.training.torch_state import tensors_of
from roadmend.world.scenario_file import outside_content

Report = Callable[[str, int, int, str], None]  # what is done, how much of it, of how much, and a word on how it goes


@dataclass
class Training:
    """One training in a folder."""

    configuration: ImitationConfiguration
    seed: int
    folder: Path
    workers: int
    device: str  # torch's name
    command: str  # goes into the header
    report: Report

    def run(self) -> Path:
        """Go through all rounds that are not there yet; returns the last model's file.

        Raises:
            InputError: the folder holds another training, or cannot be written.
            SimulationError: SUMO failed, or a worker process died.
        """
        self.folder.mkdir(parents=True, exist_ok=True)
        parts: list[Samples] = []
        model: Path | None = None
        for number in range(len(self.configuration.rounds)):
            parts.append(self._gathered(number, model))
            path = self.folder / f"round-{number}.safetensors"
            if path.exists():
                self._check(load_checkpoint(path, self.configuration.kind), path, number)
            else:
                self._fitted(number, parts, model, path)
            model = path
        assert model is not None  # there is at least one round
        return model

    def _identity(self, number: int) -> dict[str, Any]:
        """What a round follows from."""
        content = self.configuration.model_dump(mode="json")
        return {**content, "rounds": content["rounds"][: number + 1], "seed": self.seed, "device": self.device}

    def _check(self, checkpoint: Checkpoint, path: Path, number: int) -> None:
        made = checkpoint.header["configuration"].get("training", {})
        if {"device": self.device, **made} != self._identity(number):  # earlier models do not tell the device
            raise InputError(str(path), "was made with other settings", "give another folder, or delete this one")

    def _gathered(self, number: int, model: Path | None) -> Samples:
        configuration, step = self.configuration, self.configuration.rounds[number]
        lessons = [
            ordinary_lesson(family, seed, model, step.expert_share, configuration.noise, configuration.every)
            for seed in configuration.seeds(number, self.seed)
            for family in configuration.families
        ]
        before = load_checkpoint(model, configuration.kind).digest if model is not None else ""
        # What a scenario holds counts too: the code of a family from outside is in no key.
        driven = [(lesson.scenario.digest, outside_content(lesson.scenario)) for lesson in lessons]
        made_by = entry_key([__name__], self._gathering(number), before, driven)
        path = self.folder / f"round-{number}.npz"
        if path.exists():
            return load_samples(path, made_by)
        parts = []
        with fan_out(self.workers) as mapper:
            for part in mapper(gather, lessons):
                parts.append(part)
                self.report(f"round {number}: driving", len(parts), len(lessons), "")
        samples = Samples.join(parts)
        save_samples(path, samples, made_by)
        return samples

    def _gathering(self, number: int) -> dict[str, Any]:
        step, configuration = self.configuration.rounds[number], self.configuration
        return {
            "episodes": step.episodes,
            "expert_share": step.expert_share if number else 1.0,
            "noise": configuration.noise,
            "every": configuration.every,
            "families": list(configuration.families),
            "first": configuration.seeds(number, self.seed)[0],
        }

    def _fitted(self, number: int, parts: list[Samples], before: Path | None, path: Path) -> None:
        configuration, step = self.configuration, self.configuration.rounds[number]
        torch.manual_seed(self.seed * 1000 + number)
        parent = load_checkpoint(before, configuration.kind) if before is not None else None
        if parent is None or before is None:
            network = NeuralNetwork(configuration.kind, configuration.encoder_shape, configuration.head_shape)
        else:
            network = load_network(parent, before)
        network.to(self.device)
        samples = Samples.join(parts)
        with SummaryWriter(str(self.folder / "tensorboard" / f"round-{number}")) as board:

            def note(epoch: int, learned: Losses, held: Losses | None) -> None:
                for name, losses in (("training", learned), ("held out", held)):
                    for key, value in asdict(losses).items() if losses is not None else ():
                        board.add_scalar(f"{key}/{name}", value, epoch)
                how = "no episode held out" if held is None else f"{held.action:.3f} + {held.change:.4f} nat"
                self.report(f"round {number}: learning", epoch + 1, step.epochs, how)

            held = fit(
                network, samples, configuration, step, self.seed * 1000 + number, torch.device(self.device), note
            )
        outcomes = Counter(parts[-1].outcomes)
        header = {
            "kind": configuration.kind,
            "configuration": {
                "encoder": configuration.encoder_shape.model_dump(mode="json"),
                "head": configuration.head_shape.model_dump(mode="json"),
                "training": self._identity(number),
                "command": self.command,
            },
            "data_digest": samples_digest(samples),
            "metrics": {
                "held_out": None if held is None else asdict(held),
                "scenes": len(samples),
                "last_outcomes": dict(sorted(outcomes.items())),
            },
            "ancestry": [parent.digest, *parent.header["ancestry"]] if parent is not None else [],
        }
        save_checkpoint(path, tensors_of(network), header)
