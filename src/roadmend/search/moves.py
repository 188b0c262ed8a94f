"""Moves through a parameter space: mutation, crossover and distance. What comes out lies in the space."""

import random
from collections.abc import Mapping

from roadmend.world.space import Choice, Dimension, Parameters, Space, Uniform, Value, Whole


def mutate(space: Space, parameters: Parameters, rate: float, strength: float, generator: random.Random) -> Parameters:
    """A changed copy of a point; at least one dimension is moved.

    Args:
        space: where the point lies.
        parameters: the point.
        rate: probability that a dimension is moved.
        strength: standard deviation of a move as a share of the dimension's range.
        generator: source of chance.
    """
    names = [name for name in space if generator.random() < rate] or [generator.choice(list(space))]
    moved = {name: _move(space[name], parameters[name], strength, generator) for name in names}
    return {name: moved.get(name, parameters[name]) for name in space}


def _move(dimension: Dimension, value: Value, strength: float, generator: random.Random) -> Value:
    match dimension:
        case Uniform(low, high):
            step = generator.gauss(0.0, strength * (high - low))
            # Rounding may leave a range whose bounds have more digits.
            return min(high, max(low, round(_reflect(float(value) + step, low, high), 3)))
        case Whole(low, high) if high > low:
            step = max(1, round(abs(generator.gauss(0.0, strength * (high - low)))))
            return round(_reflect(int(value) + generator.choice((-step, step)), low, high))
        case Choice(weights) if len(weights) > 1:
            others = {option: weight for option, weight in weights.items() if option != value and weight > 0.0}
            return generator.choices(list(others), list(others.values()))[0] if others else value
        case _:
            return dimension.sample(generator)


def _reflect(value: float, low: float, high: float) -> float:
    """Fold a value back into a range at its bounds, so that the bounds do not gather what was drawn beyond them."""
    width = high - low
    if width <= 0.0:
        return low
    offset = (value - low) % (2.0 * width)
    return low + (offset if offset <= width else 2.0 * width - offset)


def cross(space: Space, first: Parameters, second: Parameters, generator: random.Random) -> Parameters:
    """Uniform crossover: each participant, and each dimension of the road, comes from either parent.

    What describes one participant (``v3.kind``, ``v3.speed``, ...) stays together: apart it means nothing.
    """
    from_second: dict[str, bool] = {}
    for name in space:
        group = name.partition(".")[0]
        if group not in from_second:
            from_second[group] = generator.random() < 0.5
    return {name: (second if from_second[name.partition(".")[0]] else first)[name] for name in space}


def distance(space: Space, first: Mapping[str, Value], second: Mapping[str, Value]) -> float:
    """Mean difference over the dimensions, each from 0 to 1."""
    total = 0.0
    for name, dimension in space.items():
        one, other = first[name], second[name]
        match dimension:
            case Uniform(low, high) | Whole(low, high) if high > low:
                total += abs(float(one) - float(other)) / (high - low)
            case _:
                total += float(one != other)
    return total / max(len(space), 1)
