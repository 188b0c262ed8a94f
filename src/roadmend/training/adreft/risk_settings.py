"""Settings of a risk monitor's training: the single source of default, range and meaning."""

from typing import Literal

from pydantic import Field

from roadmend.core.parameters import Parameters
from roadmend.networks.shape import Width
from roadmend.world.families import FAMILIES, FamilyName


class RiskSettings(Parameters):
    """How drives are gathered, and how a monitor learns of them."""

    families: tuple[FamilyName, ...] = Field(
        tuple(FAMILIES), min_length=1, description=f"to drive, of {', '.join(FAMILIES)}"
    )
    searched_drives: int = Field(2, ge=1, le=100, description="of each training case of the corpus")
    random_cases: int = Field(700, ge=1, le=100_000, description="scenarios drawn at random for each family and policy")
    validation_cases: int = Field(150, ge=1, le=10_000, description="ordinary drives of each family for the threshold")
    horizon: float = Field(8.0, gt=0.0, le=60.0, description="[s] within which a collision counts")
    false_alarms: float = Field(gt=0.0, lt=1.0, description="share of what is harmless in ordinary drives")
    history: bool = Field(description="whether its tokens tell of the last second and of the drive so far, too")
    head: tuple[Width, ...] = Field((64,), description="hidden widths behind the encoder")
    epochs: int = Field(5, ge=1, le=1000, description="more know what they saw by heart")
    learning_rate: float = Field(5e-4, gt=0.0, le=0.1, description="at the beginning; falls to 0 along a cosine")
    weight_decay: float = Field(0.1, ge=0.0, le=1.0, description="of AdamW")
    dropout: float = Field(0.3, ge=0.0, lt=1.0, description="between encoder and head")
    noise: float = Field(0.02, ge=0.0, le=1.0, description="standard deviation added to whatever is not 0 in a token")
    batch: int = Field(64, ge=1, le=65_536, description="ticks a step")


class ChangeSettings(RiskSettings):
    """Of a change monitor."""

    families: tuple[FamilyName, ...] = Field(
        ("S4", "S5"), min_length=1, description=f"with lane changes, of {', '.join(FAMILIES)}"
    )
    history: Literal[False] = False  # ticks at which lanes are changed come without the second before
    false_alarms: float = Field(
        0.04, gt=0.0, lt=1.0, description="share of the harmless changes of ordinary drives held back"
    )


class NeedSettings(RiskSettings):
    """Of a need monitor."""

    random_cases: int = Field(500, ge=1, le=100_000, description="scenarios drawn at random for each family and policy")
    false_alarms: float = Field(
        0.3,
        gt=0.0,
        lt=1.0,
        description="share of the harmless ordinary drives with an alarm; a threshold of the score leaves fewer",
    )
    history: bool = Field(default=True, description="it is told of the last second and of the drive so far, too")
    epochs: int = Field(2, ge=1, le=1000, description="more know what they saw by heart")
    batch: int = Field(128, ge=1, le=65_536, description="ticks a step")
