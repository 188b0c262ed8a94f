"""Parameter spaces: named dimensions that scenarios are drawn from and that search moves through."""

import random
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

Value = float | int | str | bool
Parameters = dict[str, Value]


class Dimension(Protocol):
    """One parameter: how it is drawn and which values it takes."""

    def sample(self, generator: random.Random) -> Value:
        """Draw a value."""

    def contains(self, value: Value) -> bool:
        """Whether a value is allowed."""


@dataclass(frozen=True, slots=True)
class Uniform:
    """A number between two bounds."""

    low: float
    high: float

    def sample(self, generator: random.Random) -> Value:
        """Draw uniformly; rounded so that the scenario file shows the exact value."""
        return round(generator.uniform(self.low, self.high), 3)

    def contains(self, value: Value) -> bool:
        """Whether the value lies between the bounds."""
        return isinstance(value, int | float) and self.low <= value <= self.high


@dataclass(frozen=True, slots=True)
class Whole:
    """A whole number between two bounds, both included."""

    low: int
    high: int

    def sample(self, generator: random.Random) -> Value:
        """Draw uniformly."""
        return generator.randint(self.low, self.high)

    def contains(self, value: Value) -> bool:
        """Whether the value is whole and lies between the bounds."""
        return isinstance(value, int) and self.low <= value <= self.high


@dataclass(frozen=True, slots=True)
class Choice:
    """One of several options, each with a weight."""

    weights: Mapping[Value, float]

    def sample(self, generator: random.Random) -> Value:
        """Draw by weight."""
        return generator.choices(list(self.weights), list(self.weights.values()))[0]

    def contains(self, value: Value) -> bool:
        """Whether the value is one of the options."""
        return value in self.weights


Space = Mapping[str, Dimension]


def sample(space: Space, generator: random.Random) -> Parameters:
    """Draw every dimension, in the order of their names' definition."""
    return {name: dimension.sample(generator) for name, dimension in space.items()}
