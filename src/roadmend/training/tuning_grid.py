"""The settings among which each rival's best is looked for: around and beyond its defaults."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any

Values = Mapping[str, Any]

RATES = (0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0001, 0.00001)  # false alarm rates
_PREDICTIONS = (  # horizon [s], margin [m], turning, slowing
    *((horizon, margin, True, False) for horizon in (2.0, 3.0, 4.0) for margin in (0.3, 0.8)),
    *((3.0, margin, True, True) for margin in (0.3, 0.8)),
    (4.0, 0.3, True, True),
    *((3.0, margin, False, False) for margin in (0.3, 0.8)),
    *((5.0, margin, True, False) for margin in (0.3, 0.8)),
    (6.5, 0.3, True, False),
    (8.0, 0.3, True, False),
    (5.0, 0.3, True, True),
    *((horizon, 1.5, True, False) for horizon in (3.0, 4.0, 5.0)),
)


@dataclass(frozen=True, slots=True)
class Rival:
    """A repair method and the settings to choose from."""

    name: str  # of the entry; one method may have several
    method: str
    grid: tuple[Values, ...]


def _predictions(*, adaptive: bool) -> tuple[Values, ...]:
    names = ("horizon", "margin", "turning", "slowing")
    return tuple({**dict(zip(names, values, strict=True)), "adaptive": adaptive} for values in _PREDICTIONS)


def rivals_of(model: str) -> tuple[Rival, ...]:
    """All rivals that have something to set.

    Args:
        model: the SelfOracle model, by the name of a shipped one or as a path.
    """
    return (
        Rival(
            "random",
            "random",
            tuple({"probability": value} for value in (0.02, 0.05, 0.1, 0.2, 0.35, 0.4, 0.5, 0.6, 0.75)),
        ),
        Rival(
            "rule",
            "rule",
            tuple(
                {"time_to_collision": time, "side_margin": margin, "graded": graded}
                for (time, margin), graded in product(
                    (*product((1.5, 2.5, 4.0), (0.0, 0.5)), (4.0, 1.0), (6.0, 0.5), (6.0, 1.0), (8.0, 1.0)),
                    (False, True),
                )
            ),
        ),
        Rival("model", "model", tuple({"model": model, "false_alarm_rate": rate} for rate in RATES)),
        Rival(
            "rss",
            "rss",
            tuple(
                {"rho": rho, "a_min_brake": brake, "time_gap": gap}
                for rho, brake, gap in product((0.5, 1.0, 1.5, 2.0, 2.5, 3.0), (3.0, 4.0), (0.2, 0.6))
            ),
        ),
        Rival("predictive", "predictive", _predictions(adaptive=False)),
        Rival("predictive_adaptive", "predictive", _predictions(adaptive=True)),
    )
