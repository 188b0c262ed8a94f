"""Every setting of few-shot repair: the single source of default, range and meaning."""

from pathlib import Path
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from roadmend.core.parameters import Parameters
from roadmend.core.settings import read_settings
from roadmend.networks.checkpoint import find_model
from roadmend.world.families import FAMILIES


class FewShotSettings(Parameters):
    """How a neural policy is fine-tuned on a few scenarios."""

    epochs: int = Field(4, ge=1, le=100, description="passes through the demonstrations")
    learning_rate: float = Field(3e-4, gt=0.0, le=0.1, description="at the beginning; falls to 2 % along a cosine")
    batch: int = Field(128, ge=1, le=65_536, description="scenes a step")
    weight_decay: float = Field(1e-4, ge=0.0, le=1.0, description="of AdamW")
    every: int = Field(2, ge=1, le=100, description="ticks between two samples")
    noise: float = Field(0.5, ge=0.0, le=2.0, description="standard deviation of the expert's disturbances")
    expert_drives: int = Field(1, ge=0, le=100, description="episodes a scenario that the expert drives")
    policy_drives: int = Field(3, ge=0, le=100, description="episodes a scenario that the policy drives, advised")
    repair: str = Field(
        "precaution-modular",
        description="ADReFT's model, by name or path, that repairs what the expert demonstrates; empty: none does",
    )
    expert_share: float = Field(0.2, ge=0.0, le=1.0, description="share of the time of those that the expert drives")
    replay: int = Field(60, ge=0, le=900, description="ordinary episodes of each family that old skill is kept with")
    replay_seed: int = Field(330_000, ge=50_000, le=900_000, description="of the first of these")
    replay_share: float = Field(0.5, ge=0.0, lt=1.0, description="share of the scenes of an epoch that are theirs")
    replay_repair: bool = Field(
        default=False,
        description="whether the advice in these is repaired, too: then they teach what the repair model knows, whatever "
        "the selection",
    )
    validation: int = Field(10, ge=1, le=900, description="ordinary episodes of each family that forgetting shows in")
    validation_seed: int = Field(340_000, ge=50_000, le=900_000, description="of the first of these")
    keep: Literal["best", "last"] = Field("best", description="epoch: the guard's choice, or the last without a guard")
    tolerance: float = Field(2.0, ge=0.0, le=100.0, description="Driving Score that may be lost on these")

    mixtures: tuple[Annotated[float, Field(gt=0.0, lt=1.0)], ...] = Field(
        (0.5, 0.25), description="shares of the way to the new weights that are tried where no epoch is kept"
    )

    @model_validator(mode="after")
    def _shows_something(self) -> Self:
        if not self.expert_drives + self.policy_drives:
            raise ValueError("expert_drives and policy_drives are both 0, which leaves no demonstration")
        if self.replay_repair and not self.repair:
            raise ValueError("replay_repair needs a model in repair")
        return self


def ordinary_seeds(first: int, count: int) -> list[tuple[str, int]]:
    """Families and seeds of ordinary scenarios, ``count`` of each family."""
    return [(family, first + number) for number in range(count) for family in FAMILIES]


def repair_model(settings: FewShotSettings) -> Path | None:
    """Model of ADReFT that repairs the demonstrations; None where the expert is left alone.

    Raises:
        InputError: there is no such model.
    """
    return find_model(settings.repair, "adreft-") if settings.repair else None


def read_few_shot_settings(path: Path) -> FewShotSettings:
    """Read a YAML file; names that are left out keep their defaults.

    Raises:
        InputError: it cannot be read, or a name or value is unknown or out of range.
    """
    return read_settings(path, FewShotSettings, "see config/training/few-shot.yaml")
