"""Moments: drawn where they matter, told by paired futures, the same at every call, and not looked at twice."""

import math

import numpy as np
import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.errors import InputError
from roadmend.core.plain_moment import plain_moment
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.core.source_digest import source_digest
from roadmend.policies.registry import POLICIES
from roadmend.repair.actions import ACTIONS
from roadmend.repair.registry import make_repairer
from roadmend.training.adreft.case_moments import CaseMoments
from roadmend.training.adreft.configuration import ModelSection
from roadmend.training.adreft.deferred import DeferredRepairer
from roadmend.training.adreft.gathering import Recipe
from roadmend.training.adreft.holding import HoldingRepairer
from roadmend.training.adreft.moment_plan import MomentPlan
from roadmend.training.adreft.moments import gather_moments, moment_keys, moments_of_case
from roadmend.training.adreft.network import AdreftNetwork, save_model
from roadmend.training.adreft.trial_plan import Hold
from roadmend.training.torch_state import tensors_of

from .blind import ENTRY, blind_corpus
from .cases import Drawn

PLAN = MomentPlan(moments=3, futures=2, actions=2, harmless=1.0, pulse=0.6, pulsed=1, seed=7)
RECIPE, BLIND = Recipe("modular", "rich", 1), Recipe("blind", "rich", 1)
STRONGEST = len(ACTIONS) - 1


def plan_of(**changes):
    values = {"moments": 10, "futures": 2, "actions": 2, "harmless": 0.25, "pulse": 0.6, "pulsed": 1, "seed": 7}
    return MomentPlan(**{**values, **changes})


def test_a_violation_is_looked_at_mostly_in_its_last_seconds_and_every_moment_stands_for_its_time():
    drawn = plan_of().ticks("case:alone", 20.0, violates=True, alone=True)
    numbers = np.array(sorted(drawn))
    assert numbers[-1] < 400
    assert (np.count_nonzero(numbers >= 320), np.count_nonzero((numbers >= 240) & (numbers < 320))) == (5, 3)
    assert sum(drawn.values()) == pytest.approx(20.0)
    assert drawn[numbers[-1]] == pytest.approx(4.0 / 5)
    assert drawn[numbers[0]] == pytest.approx(12.0 / 2)


@pytest.mark.parametrize(("end", "violates"), [(0.1, True), (3.0, True), (6.0, True), (30.0, False)])
def test_the_whole_drive_is_stood_for_however_short(end, violates):
    drawn = plan_of().ticks("case:alone", end, violates=violates, alone=True)
    assert sum(drawn.values()) == pytest.approx(end)
    assert all(0 <= number < round(end / 0.05) for number in drawn)


def test_drives_that_may_last_longer_are_looked_at_beyond_and_names_and_seeds_decide():
    plan = plan_of()
    beyond = plan.ticks("case:guided", 20.0, violates=False, alone=False)
    assert any(number >= 400 for number in beyond)
    assert max(beyond) < 640
    assert beyond == plan.ticks("case:guided", 20.0, violates=False, alone=False)
    assert beyond != plan_of(seed=8).ticks("case:guided", 20.0, violates=False, alone=False)
    assert beyond != plan_of(guide="a").ticks("case:guided", 20.0, violates=False, alone=False)


def test_pulses_come_at_random_times_all_along():
    drawn = [hold for number in range(50) for hold in plan_of().pulses(f"case:{number}", 30.0)]
    assert {hold.action for hold in drawn} == set(range(1, len(ACTIONS)))
    assert all(0.2 <= hold.end - hold.begin <= 2.0 for hold in drawn)
    assert max(hold.begin for hold in drawn) > 35.0
    assert 3.0 < 42.0 * 50 / len(drawn) < 8.0  # [s] from one to the next


def test_only_harder_braking_is_tried_and_little_where_nothing_would_happen():
    plan = plan_of(harmless=0.25, actions=3)
    tried = [plan.tried("case:alone", tick, 0.1, dangerous=True) for tick in range(200)]
    assert {len(each) for each in tried} == {3}
    assert {ACTIONS[index] for each in tried for index in each} == {0.0, -0.2, -0.4, -0.6, -0.8, -1.0}
    harmless = [plan.tried("case:alone", tick, 0.9, dangerous=False) for tick in range(400)]
    assert {len(each) for each in harmless} == {0, 1}
    assert 0.15 < sum(map(len, harmless)) / 400 < 0.35
    assert 0 not in {index for each in harmless for index in each}  # nothing is known of the mildest
    assert plan.tried("case:alone", 3, -1.0, dangerous=True) == []


def test_a_holding_repairer_brakes_while_it_should_and_never_pushes():
    repairer = HoldingRepairer((Hold(1.0, 1.6, STRONGEST), Hold(2.0, 3.0, 2)))

    def final(time, asked):
        ego = EgoState.from_yaw(0.0, 0.0, 0.0, 5.0, 0.0, 4.5, 1.8)
        scene = Scene(time, ego, ObjectList.empty(), np.zeros(0, dtype=np.uint8))
        repair = repairer.step(scene, Decision(Command.from_action(asked), Trajectory.empty()))
        assert repair.intervened == (repair.final_action != asked)
        return repair.final_action

    times = 0.05 * np.arange(80)
    assert sum(final(float(time), 0.5) == -1.0 for time in times) == 12
    assert final(1.6, 0.5) == 0.5
    assert final(2.0, 0.9) == pytest.approx(0.4)
    assert final(2.0, 0.1) == pytest.approx(0.1)


def test_what_is_no_command_is_made_one_as_where_the_policy_drives_alone():
    ego = EgoState.from_yaw(0.0, 0.0, 0.0, 5.0, 0.0, 4.5, 1.8)
    scene = Scene(0.0, ego, ObjectList.empty(), np.zeros(0, dtype=np.uint8))
    for asked in (Command(math.nan, 0.0), Command(0.7, 0.4), Command(-0.3, 0.0), Command(3.0, 0.0)):
        decision = Decision(asked, Trajectory.empty())
        alone = make_repairer("none")
        alone.reset(plain_moment().route)
        expected = alone.step(scene, decision).command
        assert not expected.fault
        holding = HoldingRepairer()
        assert holding.step(scene, decision).command == expected
        assert DeferredRepairer(holding, 1.0, None).step(scene, decision).command == expected


@pytest.fixture(scope="module")
def gathered(tmp_path_factory):
    folder = tmp_path_factory.mktemp("moments")
    [found] = gather_moments([Drawn("S5", 3)], RECIPE, PLAN, folder, map)
    return folder, found


def test_where_nothing_happens_the_danger_is_none_and_pulses_can_only_cause(gathered):
    _, found = gathered
    assert not found.violates
    assert 5 <= len(found) <= 6  # three of the plain drive, three of the other, the last perhaps not reached
    assert not found.danger.any()
    assert found.span[:3].sum() == pytest.approx(found.span[0] * 3)
    assert found.counts.sum() == len(found.tokens)
    assert found.tokens.dtype == np.float16
    assert len(found.moment)
    assert np.isnan(found.averted).all()
    assert not found.averted_of.any()
    assert (found.caused_of == PLAN.futures).all()
    assert (np.array(ACTIONS)[found.choice] < found.action[found.moment]).all()


def test_what_is_there_is_not_looked_at_again_and_what_is_damaged_is(gathered):
    folder, found = gathered
    [path] = folder.glob("*.npz")
    before = path.stat().st_mtime_ns
    gather_moments([Drawn("S5", 3)], RECIPE, PLAN, folder, map)
    assert path.stat().st_mtime_ns == before
    path.write_bytes(path.read_bytes()[:1000])
    [again] = gather_moments([Drawn("S5", 3)], RECIPE, PLAN, folder, map)
    for name in ("tokens", "danger", "caused", "choice", "span"):
        np.testing.assert_array_equal(getattr(again, name), getattr(found, name))
    assert CaseMoments.load(path).violates is False


def test_of_a_violation_futures_tell_the_danger_and_what_braking_averts(monkeypatch):
    monkeypatch.setitem(POLICIES, "blind", ENTRY)
    [case] = (case for case in blind_corpus(1, 0).cases if case.is_violation)
    found = moments_of_case(case, BLIND, plan_of(moments=6, pulse=2.0, pulsed=0, actions=3))
    late = found.time > case.duration - 1.0
    assert found.violates
    assert found.danger[found.time > case.duration - 4.0].mean() > 0.5
    assert found.danger[late].min(initial=1.0) == 1.0
    assert ((found.danger >= 0.0) & (found.danger <= 1.0)).all()
    behind = found.averted_of + found.caused_of
    assert (behind[found.danger[found.moment] > 0.0] >= 1).all()
    np.testing.assert_allclose(found.averted_of, 2 * found.danger[found.moment])
    assert np.nanmax(found.averted) == 1.0


def test_a_model_at_work_is_looked_at_in_its_own_states(tmp_path):
    model = ModelSection(tokenizer="rich", hidden=8, layers=1, heads=1, feed_forward=8, monitor=[4], adapter=[4])
    configuration = model.configuration()
    tensors = tensors_of(AdreftNetwork(configuration))
    last = max(name for name in tensors if name.startswith("adapter.") and name.endswith("weight"))
    tensors[last] = np.zeros_like(tensors[last])
    bias = last.removesuffix("weight") + "bias"
    tensors[bias] = np.eye(1, len(ACTIONS), STRONGEST, dtype=np.float32)[0]
    path = tmp_path / "guide.safetensors"
    digest = save_model(path, configuration, tensors, 0.0)
    plan = MomentPlan(6, 2, 1, 0.0, 0.6, 1, 7, digest)
    found = moments_of_case(Drawn("S5", 3), RECIPE, plan, path)
    assert len(found) == 6  # it stands, so that all are reached
    assert found.time[-1] > 30.0
    assert not len(found.moment)
    cases = [Drawn("S5", 3)]
    assert moment_keys(cases, RECIPE, plan) != moment_keys(cases, RECIPE, MomentPlan(6, 2, 1, 0.0, 0.6, 1, 7))


def test_what_is_kept_goes_by_the_code_of_the_model_that_drives_along():
    own = moments_of_case.__module__
    assert source_digest([own, "roadmend.repair.adreft.method"]) == source_digest([own])


def test_a_case_that_is_driven_otherwise_is_refused():
    with pytest.raises(InputError, match="does not drive it as the corpus says"):
        moments_of_case(Drawn("S5", 3, digest="0" * 64), RECIPE, PLAN)
