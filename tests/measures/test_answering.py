"""What a method does is passed on; what the guard does in its place is raised."""

import pytest

from roadmend.core.errors import RoadmendError
from roadmend.measures.answering import Answering
from roadmend.policies.registry import make_policy
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.registry import make_repairer
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode

from .failing import SAID, FailingMethod


def test_of_a_method_that_answers_nothing_changes():
    scenario = sample_scenario("S5", 3)
    plain = run_episode(scenario, make_policy("modular"), make_repairer("rss"))
    assert run_episode(scenario, make_policy("modular"), Answering(make_repairer("rss"))) == plain


def test_where_the_method_fails_the_drive_ends_with_what_it_failed_by():
    ticks = []
    repairer = Answering(GuardedRepairer(FailingMethod(5)))
    with pytest.raises(RoadmendError) as raised:
        run_episode(sample_scenario("S5", 3), make_policy("modular"), repairer, lambda *_: ticks.append(1))
    assert str(raised.value) == SAID
    assert len(ticks) == 5
