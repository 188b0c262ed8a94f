"""A bag as tables of pandas, held against what the core reads."""

from pathlib import Path

import pytest

from roadmend import InputError, read_bag
from roadmend.recording.episode import read_episode

SAMPLES = Path(__file__).parents[2] / "bags" / "samples"


@pytest.fixture(scope="module")
def bag():
    return read_bag(SAMPLES / "repaired")


@pytest.fixture(scope="module")
def episode():
    return read_episode(SAMPLES / "repaired")


def test_ticks(bag, episode):
    assert [*bag.ticks.index] == [stamp * 1e-9 for stamp in episode.stamps]
    stamp = episode.stamps[40]
    row, ego, repair = bag.ticks.loc[stamp * 1e-9], episode.ego[stamp], episode.repairs[stamp]
    assert (row.x, row.y, row.yaw, row.speed, row.yaw_rate) == (ego.x, ego.y, ego.yaw, ego.speed, ego.yaw_rate)
    assert (row.status, row.final_action, row.score) == (repair.status.name, repair.final_action, repair.score)
    assert bag.ticks.intervened.sum() == sum(repair.intervened for repair in episode.repairs.values())


def test_objects(bag, episode):
    stamp = next(stamp for stamp, objects in episode.objects.items() if len(objects))
    objects = episode.objects[stamp]
    table = bag.objects.loc[stamp * 1e-9]
    assert [*table.index] == [*objects.id]
    assert [*table.x] == [*objects.x]
    assert set(bag.objects.kind) <= {"CAR", "TRUCK", "BUS", "MOTORCYCLE", "BICYCLE", "PEDESTRIAN", "UNKNOWN"}
    assert len(bag.objects) == sum(map(len, episode.objects.values()))


def test_interventions_are_the_spells_and_agree_with_the_ticks(bag, episode):
    spells = episode.spells()
    assert spells
    table = bag.interventions
    assert [*table.begin] == [account.spell.begin for account in spells]
    assert [*table.because_of] == [[sight.object_id for sight in account.who] for account in spells]
    for row in table.itertuples():
        during = bag.ticks.loc[row.begin - 1e-6 : row.begin + row.duration - 0.05 + 1e-6]
        assert len(during) == row.ticks
        assert during.intervened.all()
        assert during.final_action.min() == pytest.approx(row.strongest)
        assert 0.05 * (during.policy_action - during.final_action).abs().sum() == pytest.approx(row.dose)


def test_events_and_account(episode):
    collision = read_bag(SAMPLES / "collision")
    final = collision.events.iloc[-1]
    assert (final.kind, final.blame) == ("COLLISION", collision._episode.events[-1].blame.name)
    assert final.impact_speed > 0.0
    assert len(final.with_whom) == 1
    assert collision.account["outcome"] == "COLLISION"


def test_what_is_no_bag_is_refused(tmp_path):
    with pytest.raises(InputError):
        read_bag(tmp_path)
