"""One episode: who touched whom with which side, and where everybody was."""

import pytest

from roadmend.core.errors import SimulationError
from roadmend.safe.construction import draw_scenario
from roadmend.safe.contact import Part
from roadmend.safe.reproduction import reproduce
from roadmend.safe.trial import run_trial

from .crashes import ALL, role


def test_the_sides_of_a_contact_are_those_that_touch():
    found = reproduce(role(ALL["rear end"], 1), "modular", 30)
    trial = run_trial(found.scenario, "modular")
    assert trial.film.ego_name == "v2"
    assert trial.contact.of("v2").part.is_near(Part.REAR)
    assert trial.contact.of("v1").part.is_near(Part.FRONT)
    assert trial.moment == trial.contact.tick == len(trial.film.ego) - 1
    assert trial.is_physical


def test_an_episode_that_begins_in_a_collision_is_refused():
    scenario = draw_scenario(role(ALL["parked"]), 0)
    actor = scenario.actors[0].model_copy(update={"position": scenario.ego.position + 3.0})
    with pytest.raises(SimulationError, match="begins with a collision"):
        run_trial(scenario.model_copy(update={"actors": [actor]}), "modular")


def test_the_film_of_somebody_alone_has_a_middle():
    trial = run_trial(draw_scenario(role(ALL["alone"]), 0), "modular")
    assert trial.film.nearest() == len(trial.film.ego) // 2
    assert trial.film.track("v2").shape == (0, 5)
    assert (trial.contact, trial.summary.collided, trial.summary.final.at_fault) == (None, False, False)
