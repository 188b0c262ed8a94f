import pytest

from roadmend.repair.governor import GovernorRepair
from roadmend.repair.parameters import GovernorParameters

from .playground import ego_at, keep_on, scene_of, straight_route


def propose(speed, **parameters):
    method = GovernorRepair(GovernorParameters(**parameters))
    route = straight_route()
    method.reset(route)
    scene = scene_of([], ego=ego_at(speed=speed))
    return method.propose(scene, keep_on(scene)), float(route.stages[0].speed_limit[0])


@pytest.mark.parametrize("share", [0.7, 0.9])
def test_it_brakes_in_proportion_above_the_share_and_not_below(share):
    _, limit = propose(1.0)
    below, _ = propose(share * limit - 0.1, share=share)
    above, _ = propose(share * limit + 0.5, share=share, gain=0.4)
    far, _ = propose(share * limit + 20.0, share=share)
    assert below.score < below.threshold
    assert above.score > above.threshold
    assert above.action == pytest.approx(-0.2)
    assert far.action == -1.0
    assert "are allowed" in above.reason
    assert not below.reason


def test_without_an_episode_it_says_so():
    scene = scene_of([])
    with pytest.raises(RuntimeError, match="call reset first"):
        GovernorRepair().propose(scene, keep_on(scene))
