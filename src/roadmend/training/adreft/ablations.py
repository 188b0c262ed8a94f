"""What is left out of ADReFT's training to see what it is worth (ADReFT's table 4, and one of our own)."""

from typing import Any

from roadmend.core.errors import InputError
from roadmend.training.adreft.configuration import TrainingConfiguration
from roadmend.training.adreft.pipeline import Only

ABLATIONS: dict[str, tuple[Only, dict[str, dict[str, Any]]]] = {  # which stage alone, and what is set
    "rand_r": ("supervised", {"model": {"choice": "random"}}),
    "only_sl": ("supervised", {}),
    "only_rl": (None, {"reinforcement": {"start": "scratch"}}),
    "wo_sr": (None, {"reinforcement": {"step_reward": False}}),
    "wo_regulation": (None, {"frames": {"labels": "weak_without_regulation"}, "practice": {"near": 0.0}}),
}


def ablated(configuration: TrainingConfiguration, name: str, only: Only) -> tuple[Only, TrainingConfiguration]:
    """Which stage alone, and the configuration, with something left out.

    Args:
        configuration: whole.
        name: of ``ABLATIONS``.
        only: the stage that was asked for.

    Raises:
        InputError: the configuration does not have what is to be left out.
    """
    stage, changes = ABLATIONS[name]
    changed = TrainingConfiguration.model_validate(_merged(configuration.model_dump(), changes))
    if "reinforcement" in changes and not changed.reinforcement.episodes:
        mend = "set reinforcement.episodes, or give --config config/training/adreft-paper.yaml"
        raise InputError("--ablation", f"'{name}' changes fine-tuning, of which this configuration has none", mend)
    return stage or only, changed


def _merged(content: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Some content with other values at the places that the changes name."""
    return content | {
        name: _merged(content[name], value) if isinstance(value, dict) else value for name, value in changes.items()
    }
