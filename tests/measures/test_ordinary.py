from dataclasses import replace

import pytest

from roadmend.core.outcome import Blame
from roadmend.core.spell import Spell
from roadmend.measures.ordinary import ordinary_figures

from .results import episode


def spell(begin, ticks, dose, need=None):
    return Spell(begin, ticks, dose / 0.05, need)


def drive(outcome="GOAL", duration=20.0, distance=200.0, spells=(), blame=Blame.UNKNOWN):
    ticks, change = sum(each.ticks for each in spells), sum(each.change for each in spells)
    result = episode(outcome, interventions=ticks, change=change, blame=blame)
    return replace(result, duration=duration, distance=distance, spells=tuple(spells))


def test_of_no_drives_nothing_is_told():
    found = ordinary_figures([])
    assert (found.drives, found.untouched, found.time_lost, found.spells_per_km) == (0, None, None, None)


def test_figures_by_hand():
    needed, needless = spell(1.0, 10, 0.4, 0.9), spell(3.0, 4, 0.1, 0.05)
    found = ordinary_figures(
        [
            (drive(), drive(duration=22.0, spells=[needed, needless])),  # 10 % of the time
            (drive(), drive(spells=[needless])),
            (drive("TIMEOUT", 60.0, 500.0), drive("TIMEOUT", 60.0, 400.0)),  # 20 % of the way
            (drive("COLLISION", blame=Blame.FRONT), drive(duration=99.0)),  # no ordinary drive
        ]
    )
    assert found.drives == 3
    assert found.untouched == pytest.approx(200.0 / 3.0)
    assert (found.time_lost, found.time_lost_median) == (pytest.approx(5.0), pytest.approx(5.0))
    assert found.distance_lost == pytest.approx(20.0)
    assert found.needless_dose_per_hour == pytest.approx(0.2 / (102.0 / 3600.0))
    assert found.needless_dose_per_km == pytest.approx(0.2 / 0.8)
    assert found.spells_per_km == pytest.approx(3.0 / 0.8)
    assert found.spells_needed == pytest.approx(100.0 / 3.0)
    assert (found.collisions_bare, found.collisions, found.new_collisions) == (1, 0, 0)


def test_a_collision_that_the_policy_alone_does_not_have_is_new_only_by_the_egos_fault():
    blamed, hit = drive("COLLISION", blame=Blame.FRONT), drive("COLLISION", blame=Blame.EGO_STOOD)
    found = ordinary_figures([(drive(), blamed), (drive(), hit), (blamed, blamed)])
    assert (found.collisions_bare, found.collisions, found.new_collisions) == (1, 2, 1)
    assert (found.struck_bare, found.struck, found.cut_short) == (1, 3, 2)


def test_without_the_need_of_a_spell_nobody_knows_what_was_needless():
    found = ordinary_figures([(drive(), drive(spells=[spell(1.0, 1, 0.05, 0.0), spell(2.0, 1, 0.05)]))])
    assert found.needless_dose_per_hour is None
    assert found.spells_needed is None
    assert found.spells_per_km == pytest.approx(10.0)


def test_interventions_of_drives_that_go_wrong_count_among_the_needed():
    crash = drive("COLLISION", blame=Blame.FRONT)
    found = ordinary_figures(
        [(drive(), drive(spells=[spell(1.0, 1, 0.05, 0.1)])), (crash, drive(spells=[spell(1.0, 1, 0.05, 0.2)]))]
    )
    assert (found.drives, found.spells_needed) == (1, pytest.approx(50.0))
    assert ordinary_figures([(drive(), drive())]).spells_needed is None


def test_who_collides_early_wins_no_time_by_it():
    crashed = drive("COLLISION", duration=2.0, distance=10.0, blame=Blame.FRONT)
    found = ordinary_figures([(drive(), crashed), (drive(), drive(duration=21.0))])
    assert found.time_lost == pytest.approx(5.0)
    assert (found.new_collisions, found.cut_short) == (1, 1)


@pytest.mark.parametrize("end", ["OFF_ROUTE", "ABORTED", "COLLISION"])
def test_nor_does_who_leaves_the_lane_or_gives_up_and_no_way_is_lost_by_it(end):
    found = ordinary_figures(
        [
            (drive(), drive(end, duration=15.0)),
            (drive(), drive(duration=21.0)),
            (drive(), drive("TIMEOUT", duration=23.0)),
            (drive("TIMEOUT", 60.0, 500.0), drive(end, 10.0, 50.0)),
            (drive("TIMEOUT", 60.0, 500.0), drive("GOAL", 55.0, 450.0)),
            (drive(end), drive(end, duration=5.0)),  # as it was alone: nothing is cut
        ]
    )
    assert found.time_lost == found.time_lost_median == pytest.approx(10.0)
    assert found.distance_lost == pytest.approx(10.0)
    assert (found.drives, found.cut_short) == (6, 2)
