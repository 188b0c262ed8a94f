"""Shapes of the networks: all that is needed, beside the tensors, to build one again."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from roadmend.core.parameters import Parameters

Width = Annotated[int, Field(ge=1, le=4096)]
Place = Annotated[int, Field(ge=0, le=4096)]


def _share_evenly(hidden: int, heads: int) -> None:
    if hidden % heads:
        raise ValueError(f"heads: {heads} cannot share a hidden width of {hidden} evenly")


class EncoderShape(Parameters):
    """A BERT-style encoder of a set of tokens (Devlin et al. 2019; ADReFT, section 4.1, "state encoder").

    It has no positions: a scene is a set, and every token carries its own place.
    """

    attributes: int = Field(ge=1, le=256, description="c, attributes of a token")
    hidden: Width = Field(64, description="H, width of a token inside and of the scene's state")
    layers: int = Field(2, ge=1, le=24, description="transformer layers")
    heads: int = Field(4, ge=1, le=64, description="attention heads; they share the width evenly")
    feed_forward: Width = Field(128, description="width between the two linear maps of a layer")
    activation: Literal["relu", "gelu"] = Field(
        "relu", description="between these two; gelu is the exact one, with erf"
    )

    @model_validator(mode="after")
    def _heads_share_evenly(self) -> "EncoderShape":
        _share_evenly(self.hidden, self.heads)
        return self

    @property
    def state(self) -> int:
        """Width of the scene's state."""
        return self.hidden


class SetShape(Parameters):
    """A Deep Sets encoder (Zaheer et al. 2017): the same perceptron on every token, and the largest value of each output.

    What the first token, the ego's, came to stands beside the largest values.
    """

    attributes: int = Field(ge=1, le=256, description="c, attributes of a token")
    hidden: tuple[Width, ...] = Field((64,), description="widths between")
    outputs: Width = Field(64, description="H, width of a token at the end")

    @property
    def token_shape(self) -> "HeadShape":
        """The perceptron on a token."""
        return HeadShape(inputs=self.attributes, hidden=self.hidden, outputs=self.outputs)

    @property
    def state(self) -> int:
        """Width of the scene's state."""
        return 2 * self.outputs


class ExcerptShape(Parameters):
    """No network: some columns of some of the first tokens, one after another. Everything else stays unseen."""

    attributes: int = Field(ge=1, le=256, description="c, attributes of a token")
    places: tuple[tuple[Place, Place], ...] = Field(min_length=1, description="token and column of each value")

    @model_validator(mode="after")
    def _are_there(self) -> "ExcerptShape":
        column = max(column for _, column in self.places)
        if column >= self.attributes:
            raise ValueError(f"places: there is no column {column} of {self.attributes}, counted from 0")
        return self

    @property
    def state(self) -> int:
        """Width of the scene's state."""
        return len(self.places)


class HeadShape(Parameters):
    """A multi-layer perceptron with a rectifier after every layer but the last."""

    inputs: Width = Field(description="width of the input")
    hidden: tuple[Width, ...] = Field((64,), description="widths between; none: a linear map")
    outputs: Width = Field(description="width of the output")

    @property
    def widths(self) -> tuple[int, ...]:
        """All widths from the input to the output."""
        return (self.inputs, *self.hidden, self.outputs)


class TextShape(Parameters):
    """A BERT encoder of a text (Devlin et al. 2019) whose pieces of words may bear a mark: whom they speak of."""

    pieces: int = Field(ge=1, le=200_000, description="pieces of words that it knows")
    positions: int = Field(512, ge=1, le=8192, description="longest text, in pieces")
    marks: int = Field(ge=1, le=64, description="marks that a piece may bear, 0 for none among them")
    hidden: Width = Field(384, description="H, width of a piece inside")
    layers: int = Field(6, ge=1, le=24, description="transformer layers")
    heads: int = Field(12, ge=1, le=64, description="attention heads; they share the width evenly")
    feed_forward: Width = Field(1536, description="width between the two linear maps of a layer")

    @model_validator(mode="after")
    def _heads_share_evenly(self) -> "TextShape":
        _share_evenly(self.hidden, self.heads)
        return self

    @property
    def layer(self) -> EncoderShape:
        """The shape of its layers."""
        return EncoderShape(
            attributes=1,
            hidden=self.hidden,
            layers=self.layers,
            heads=self.heads,
            feed_forward=self.feed_forward,
            activation="gelu",
        )
