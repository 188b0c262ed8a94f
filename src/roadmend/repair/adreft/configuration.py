"""What a model of ADReFT is built from: all that is needed, beside its tensors, to run it."""

import json
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, field_validator, model_validator

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.networks.shape import EncoderShape, HeadShape
from roadmend.repair.actions import ACTIONS
from roadmend.repair.adreft.risk_monitor import RiskConfiguration
from roadmend.repair.adreft.weighing import OUTPUTS, Weighing

Width = Annotated[int, Field(ge=1, le=4096)]


class Deciding(Parameters):
    """How monitor and adapter are built, and how a choice comes of what they say."""

    monitor: tuple[Width, ...] = Field((64,), description="hidden widths of the state monitor")
    adapter: tuple[Width, ...] = Field((64,), description="hidden widths of the decision adapter")
    choice: Literal["greedy", "random"] = Field(
        "greedy", description="the action of greatest value, or a uniformly random one (the ablation Rand-R)"
    )
    interval: int = Field(
        1, ge=1, le=100, description="ticks for which a choice of the adapter holds; the paper's is 1"
    )
    margin: float = Field(
        0.0,
        ge=0.0,
        le=100.0,
        description="how much more than the policy's own action a choice must be worth; the paper's is 0",
    )
    hold: float = Field(0.0, ge=0.0, le=2.0, description="least duration of an intervention [s]; the paper's is 0")
    clear: float = Field(
        0.0, ge=0.0, le=2.0, description="how long the score must be low before release [s]; the paper's is 0"
    )
    opening: float = Field(
        0.0, ge=0.0, le=2.0, description="seconds of full braking with which an intervention begins; the paper's is 0"
    )
    pressing: float = Field(
        0.0,
        ge=0.0,
        le=1.0,
        description="risk by the need monitor above which an intervention brakes in full as long as it stays there, "
        "whatever the adapter chooses; 0: never, as the paper's",
    )
    fresh: bool = Field(
        default=False,
        description="a choice is made when an intervention begins and every `interval` ticks from there, and ends it "
        "where it does not brake; else the ticks are counted from the episode's first, as the paper's",
    )
    longest: float = Field(
        0.0, ge=0.0, le=60.0, description="seconds of intervention after which it is let go (see `patience`); 0: never"
    )
    standstill: float = Field(
        0.0, ge=0.0, le=60.0, description="seconds at a standstill under intervention after which it is; 0: never"
    )
    holding: float = Field(
        -1.0,
        ge=-1.0,
        le=-0.2,
        description="throttle - brake with which an ego that stands is held at most, one of the actions; -1: as hard as it "
        "would be braked at speed, as the paper's",
    )
    lane_change: float = Field(
        0.0,
        ge=0.0,
        le=10.0,
        description="while the ego changes lanes it is braked only for somebody ahead whom it would reach within so many "
        "seconds at today's speeds; 0: for whomever, as the paper's",
    )
    weighing: Weighing | None = Field(
        None, description="prices, where the adapter foresees collisions; without, it gives the values, as the paper's"
    )

    @field_validator("holding")
    @classmethod
    def _is_an_action(cls, holding: float) -> float:
        if holding not in ACTIONS:
            raise ValueError(
                f"holding: {holding:g} is none of the actions {', '.join(f'{each:g}' for each in ACTIONS)}"
            )
        return holding


class ModelConfiguration(Deciding):
    """Saved in every model's header."""

    tokenizer: str = Field(description="name of the tokenizer")
    tokenizer_version: int = Field(ge=1, description="version of the tokenizer that the model was trained with")
    encoder: EncoderShape = Field(description="shape of the state encoder")
    need: RiskConfiguration | None = Field(
        None,
        description="of the monitor that an intervention must be needed for; none: the score decides, as the paper's",
    )
    change: RiskConfiguration | None = Field(
        None,
        description="of the monitor that holds back lane changes; none: they are the policy's affair, as the paper's",
    )

    @model_validator(mode="after")
    def _who_presses_knows_the_risk(self) -> "ModelConfiguration":
        if self.pressing > 0.0 and self.need is None:
            raise ValueError("pressing: needs a model with a need monitor, whose risk it is compared with")
        return self

    @property
    def risks(self) -> dict[str, RiskConfiguration]:
        """The risk monitors that there are, by the names of their tensors."""
        return {name: each for name, each in (("need", self.need), ("change", self.change)) if each is not None}

    @property
    def monitor_shape(self) -> HeadShape:
        """The state monitor looks at the scene's state and the policy's action (ADReFT section 3.1.2)."""
        return HeadShape(inputs=self.encoder.hidden + 1, hidden=self.monitor, outputs=1)

    @property
    def adapter_shape(self) -> HeadShape:
        """The decision adapter gives one value for each action (ADReFT section 3.1.3), or what a value is made of."""
        outputs = len(ACTIONS) if self.weighing is None else OUTPUTS
        return HeadShape(inputs=self.encoder.hidden, hidden=self.adapter, outputs=outputs)


def read_configuration(where: str, header: Mapping[str, Any]) -> ModelConfiguration:
    """The configuration in a model's header.

    Raises:
        InputError: it is missing or of another version of roadmend.
    """
    try:
        return ModelConfiguration.model_validate_json(json.dumps(header["configuration"]["model"]))
    except (ValidationError, KeyError, TypeError) as error:
        text = error.errors()[0]["msg"] if isinstance(error, ValidationError) else f"it has no {error}"
        mend = "train the model again with this version of roadmend"
        raise InputError(where, f"its configuration is not that of a model of ADReFT ({text})", mend) from None
