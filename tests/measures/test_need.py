import pytest

from roadmend.core.errors import InputError
from roadmend.core.resources import config_folder
from roadmend.measures.need import PERSISTENT, persistence, run_with_need
from roadmend.measures.need_verdict import NEEDLESS
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.corpus import corpus_of
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode
from roadmend.world.scenario_file import load_scenario


@pytest.fixture(scope="module")
def violation():
    """In which ADReFT saves the modular policy."""
    return load_scenario(config_folder() / "scenarios" / "demo-exit.yaml")


def test_the_need_of_spells_is_told_and_nothing_else_moves(violation):
    told = run_with_need(violation, make_policy("modular"), make_repairer("adreft"), 5)
    alone = run_episode(violation, make_policy("modular"), make_repairer("adreft"))
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


def test_persistence_is_the_share_of_futures_that_violate_again():
    case = next(
        case for case in corpus_of("modular").select("S4", "test", violation=True) if case.persistence >= PERSISTENT
    )
    again = persistence(case.scenario(), make_policy("modular"), case.duration, 20)
    assert again == case.persistence
    with pytest.raises(InputError, match="ends before"):
        persistence(case.scenario(), make_policy("modular"), case.duration + 60.0, 1)
