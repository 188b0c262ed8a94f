"""Every hyper-parameter of a neural policy's training: the single source of default, range and meaning."""

from pathlib import Path
from typing import Literal, Self

from pydantic import Field, model_validator

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.settings import read_settings
from roadmend.networks.shape import EncoderShape, ExcerptShape, HeadShape, SetShape, Width
from roadmend.policies.neural_kinds import KINDS, AnyShape
from roadmend.policies.neural_tokens import COLUMNS, OWN
from roadmend.training.adreft.random_case import FIRST_SEED
from roadmend.world.families import FAMILIES, FAMILY_REGISTRY

SEEDS_A_ROUND = 1000  # apart
_ROUNDS = 50  # at most
_LAST_FIRST_SEED = 900_000
# Of a training, so that its scenarios lie below those that ADReFT's are drawn from.
LAST_SEED = (FIRST_SEED - _LAST_FIRST_SEED) // (_ROUNDS * SEEDS_A_ROUND) - 1


class Round(Parameters):
    """One round of gathering and learning: behaviour cloning first, DAgger after it (Ross et al. 2011)."""

    episodes: int = Field(60, ge=1, le=900, description="new episodes of each family")
    expert_share: float = Field(0.0, ge=0.0, le=1.0, description="share of the time during which the expert drives")
    epochs: int = Field(4, ge=1, le=200, description="passes through the data of this and all earlier rounds")
    learning_rate: float = Field(1e-3, gt=0.0, le=0.1, description="at the beginning; falls to 2 % along a cosine")


class ImitationConfiguration(Parameters):
    """How a neural policy is trained."""

    kind: Literal["neural", "ego_mlp", "deep_sets"] = Field("neural", description="of policy")
    first_seed: int = Field(200_000, ge=50_000, le=_LAST_FIRST_SEED, description="of the scenarios that are driven")
    families: tuple[str, ...] = Field(tuple(FAMILIES), min_length=1, description="families of scenarios")
    every: int = Field(4, ge=1, le=100, description="ticks between two samples")
    noise: float = Field(0.5, ge=0.0, le=2.0, description="standard deviation of the expert's disturbances")
    hidden: int = Field(64, ge=4, le=512, description="H, width of a token inside")
    layers: int = Field(2, ge=1, le=12, description="layers of the transformer, or of the perceptron on a token")
    heads: int = Field(4, ge=1, le=64, description="attention heads")
    feed_forward: int = Field(128, ge=4, le=2048, description="width of a layer's feed-forward part")
    head: tuple[Width, ...] = Field((64,), description="hidden widths of the action head")
    batch: int = Field(256, ge=1, le=65_536, description="scenes a step")
    weight_decay: float = Field(1e-4, ge=0.0, le=1.0, description="of AdamW")
    change_weight: float = Field(1.0, ge=0.0, le=100.0, description="of the lane change's loss beside the action's")
    held_out: float = Field(0.05, gt=0.0, le=0.5, description="share of the episodes that losses are measured on")
    rounds: tuple[Round, ...] = Field((Round(),), min_length=1, max_length=_ROUNDS, description="one after another")

    @model_validator(mode="after")
    def _has_a_shape(self) -> Self:
        self.encoder_shape  # noqa: B018 - the heads must share the width
        return self

    @property
    def encoder_shape(self) -> AnyShape:
        """The shape of the encoder."""
        if KINDS[self.kind].shape is ExcerptShape:
            return ExcerptShape(attributes=COLUMNS, places=OWN)
        if KINDS[self.kind].shape is SetShape:
            return SetShape(attributes=COLUMNS, hidden=(self.hidden,) * (self.layers - 1), outputs=self.hidden)
        return EncoderShape(
            attributes=COLUMNS,
            hidden=self.hidden,
            layers=self.layers,
            heads=self.heads,
            feed_forward=self.feed_forward,
            activation="relu",
        )

    @property
    def head_shape(self) -> HeadShape:
        """The shape of the head."""
        return HeadShape(inputs=self.encoder_shape.state, hidden=self.head, outputs=KINDS[self.kind].outputs)

    def seeds(self, number: int, seed: int) -> range:
        """The scenarios' seeds of a round; those of another ``seed`` of the training, 0 .. LAST_SEED, do not overlap."""
        begin = self.first_seed + (seed * _ROUNDS + number) * SEEDS_A_ROUND
        return range(begin, begin + self.rounds[number].episodes)


def read_imitation_configuration(path: Path) -> ImitationConfiguration:
    """Read a YAML file; names that are left out keep their defaults.

    Raises:
        InputError: it cannot be read, or a name or value is unknown or out of range.
    """
    configuration = read_settings(path, ImitationConfiguration, "see config/training/policy-neural.yaml")
    for name in configuration.families:
        try:
            FAMILY_REGISTRY.find_installed(name)
        except InputError as error:
            raise InputError(str(path), f"families: {error.what}", error.mend) from None
    return configuration
