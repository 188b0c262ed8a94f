"""A picture of a built scenario at the moment when the ego was nearest to somebody."""

from pathlib import Path

import numpy as np

from roadmend.core.tick import INTERVAL
from roadmend.core.whole_file import written_beside
from roadmend.reports.scene_layers import Trail
from roadmend.reports.scene_picture import SceneView, draw_scene
from roadmend.safe.trial import Trial
from roadmend.world.network import network_file
from roadmend.world.road_network import lanes_of, read_network
from roadmend.world.scenario import Scenario

_DPI = 72
_SPAN = 90.0  # [m]


def draw_trial(scenario: Scenario, trial: Trial, out: Path) -> None:
    """Draw one moment of an episode into a PNG file.

    Raises:
        InputError: the file cannot be written.
    """
    tick = trial.film.nearest()
    before = trial.film.ego[: tick + 1]
    view = SceneView(
        scenario=scenario.name,
        time=tick * INTERVAL,
        ego=trial.film.ego[tick],
        objects=trial.film.objects[tick],
        lanes=lanes_of(read_network(network_file(scenario.network))),
        route=trial.route,
        trail=Trail(
            np.array([ego.x for ego in before]), np.array([ego.y for ego in before]), np.zeros(len(before), np.bool_)
        ),
        outcome=trial.summary.outcome.name.lower().replace("_", " "),
    )
    with written_beside(out) as beside:
        draw_scene(view, _SPAN).savefig(beside, dpi=_DPI, format="png")
