"""A rule that asks a monitor first: it steps in where both say so, with what the rule says."""

import pytest

from roadmend.repair.gated import GatedRepair
from roadmend.repair.parameters import GatedParameters

from .playground import Box, ego_at, keep_on, scene_of, straight_route


def propose(objects, **parameters):
    method = GatedRepair(GatedParameters(**parameters))
    method.reset(straight_route())
    scene = scene_of(objects, ego=ego_at(speed=15.0))
    return method.propose(scene, keep_on(scene))


@pytest.mark.parametrize("rule", ["rss", "predictive", "both"])
def test_it_steps_in_where_monitor_and_rule_say_so(rule):
    near = [Box(1, 14.0, 0.0)]
    both = propose(near, rule=rule, threshold=0.0)
    assert both.score > both.threshold
    assert both.action < 0.0
    assert both.triggers
    assert not propose(near, rule=rule, threshold=1.0).score > 1.0  # the monitor alone holds it back
    assert propose([], rule=rule, threshold=0.0).score == 0.0  # so does the rule, whatever the monitor says


@pytest.mark.parametrize("full", [6.0, 10.0])
def test_the_rule_brakes_with_its_share_of_the_full_deceleration(full):
    near = [Box(1, 20.0, 0.0, speed=12.0)]
    assert propose(near, rule="rss", threshold=0.0, full_brake=full).action * full == pytest.approx(-5.0)


def test_of_two_rules_the_harder_braking_counts():
    near = [Box(1, 14.0, 0.0)]
    both, *alone = (propose(near, rule=rule, threshold=0.0) for rule in ("both", "rss", "predictive"))
    assert both.action == min(each.action for each in alone)
    assert len({each.score for each in (both, *alone)}) == 1
