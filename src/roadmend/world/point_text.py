"""A point of a parameter space as a short text, exact both ways."""

import itertools
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from roadmend.world.scenario import Scenario
from roadmend.world.space import Choice, Parameters, Space, Uniform, Value, Whole

_SEPARATOR, _REPEAT = ",", "*"


class _Watched(dict[str, Value]):
    """Remembers which dimensions were asked for; who takes them all, as dict(p) and **p do, asks for all."""

    def __init__(self, parameters: Mapping[str, Value]) -> None:
        super().__init__(parameters)
        self.used: set[str] = set()

    def __getitem__(self, name: str) -> Value:
        self.used.add(name)
        return super().__getitem__(name)

    def __contains__(self, name: object) -> bool:
        self.used.add(str(name))
        return super().__contains__(name)

    def get(self, name: str, default: Any = None) -> Any:
        self.used.add(name)
        return super().get(name, default)

    def pop(self, name: str, *default: Any) -> Any:
        self.used.add(name)
        return super().pop(name, *default)

    def __iter__(self) -> Iterator[str]:
        return iter(self.keys())

    def keys(self) -> Any:
        self._use_all()
        return super().keys()

    def values(self) -> Any:
        self._use_all()
        return super().values()

    def items(self) -> Any:
        self._use_all()
        return super().items()

    def _use_all(self) -> None:
        self.used.update(super().keys())


def used_parameters(build: Callable[[Parameters, str, int], Scenario], parameters: Parameters, seed: int) -> Parameters:
    """The part of a point that its scenario depends on.

    A space has room for the densest traffic; what describes a vehicle that is not there, or how one that keeps to the
    rules would have broken them, is left out.

    Args:
        build: a family's.
        parameters: the point, complete.
        seed: of the traffic.
    """
    watched = _Watched(parameters)
    build(watched, "point", seed)
    return {name: value for name, value in parameters.items() if name in watched.used}


def dump_point(space: Space, parameters: Mapping[str, Value]) -> str:
    """Values in the order of the space, separated by commas.

    A choice is written as its place among the options, a dimension that is left out as nothing, and a run of n of
    these as ``*n``.
    """
    cells: list[str] = []
    for is_given, names in itertools.groupby(space, lambda name: name in parameters):
        if is_given:
            cells += [_dump_value(space, name, parameters[name]) for name in names]
        else:
            run = len(list(names))
            cells.append(f"{_REPEAT}{run}" if run > 1 else "")
    return _SEPARATOR.join(cells)


def _dump_value(space: Space, name: str, value: Value) -> str:
    match space[name]:
        case Choice(weights):
            return str([*weights].index(value))
        case _:
            return repr(value)


def parse_point(space: Space, text: str) -> Parameters:
    """The point that a text stands for.

    Raises:
        ValueError: the text is no point of this space.
    """
    cells: list[str] = []
    for cell in text.split(_SEPARATOR):
        cells += [""] * min(int(cell[1:]), len(space) + 1) if cell.startswith(_REPEAT) else [cell]
    if len(cells) != len(space):
        raise ValueError(f"{len(cells)} values for {len(space)} dimensions")
    parameters = {name: _parse_value(space, name, cell) for name, cell in zip(space, cells, strict=True) if cell}
    for name, value in parameters.items():
        if not space[name].contains(value):
            raise ValueError(f"{name} cannot be {value}")
    return parameters


def _parse_value(space: Space, name: str, cell: str) -> Value:
    match space[name]:
        case Choice(weights):
            options = [*weights]
            if not 0 <= int(cell) < len(options):
                raise ValueError(f"{name} has no option {cell}")
            return options[int(cell)]
        case Whole():
            return int(cell)
        case Uniform():
            return float(cell)
        case dimension:
            raise ValueError(f"{name} is of the unknown kind {type(dimension).__name__}")
