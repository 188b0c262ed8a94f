import pytest

from roadmend.measures.need import NEEDLESS, run_with_need
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.corpus import corpus_of
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode


@pytest.fixture(scope="module")
def violation():
    """The first of the corpus whose impact is hard."""
    cases = corpus_of("modular").select("S4", "test", violation=True)
    return next(case for case in cases if case.impact_speed > 6.0)


def test_the_need_of_spells_is_told_and_nothing_else_moves(violation):
    told = run_with_need(violation.scenario(), make_policy("modular"), make_repairer("adreft"), 5)
    alone = run_episode(violation.scenario(), make_policy("modular"), make_repairer("adreft"))
    assert told.digest == alone.digest
    assert [spell.begin for spell in told.spells] == [spell.begin for spell in alone.spells]
    assert all(spell.need in {0.0, 0.2, 0.4, 0.6, 0.8, 1.0} for spell in told.spells)
    assert max(spell.need for spell in told.spells) >= 0.8  # that one was the rescue
    assert sum(spell.ticks for spell in told.spells) == told.interventions
    assert sum(spell.dose for spell in told.spells) == pytest.approx(told.dose)


def test_who_brakes_at_random_on_a_quiet_road_is_not_needed():
    scenario = sample_scenario("S4", 3).model_copy(update={"time_limit": 4.0})
    told = run_with_need(scenario, make_policy("modular"), make_repairer("random", seed=1), 2)
    assert len(told.spells) > 3
    assert sum(spell.need < NEEDLESS for spell in told.spells) > 0.8 * len(told.spells)
