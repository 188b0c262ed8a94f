"""How steady an intervention is, whatever the scene calls for: when it may end and begin again, and what it jerks."""

import itertools
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.episode_result import WINDOW, peaks
from roadmend.core.repair import Proposal
from roadmend.networks.checkpoint import find_model
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.guard import GuardedRepairer
from roadmend.repair.latch import Latch
from roadmend.repair.parameters import PredictiveParameters, RssParameters
from roadmend.world.ego import LongitudinalDynamics, VehicleParameters

from .playground import ego_at, scene_of, straight_route

TICK = 0.05  # [s]
SLACK = 1e-4  # [s] against rounding in sums of ticks
CAR = VehicleParameters()
JERK_MAX = 42.5  # [m/s3] that engine and brake can do, see ``lagged``
CALM = Proposal(0.2, 0.5, 1.0)

braking = st.floats(-1.0, 0.8)
alarms = st.lists(st.none() | braking, min_size=1, max_size=120)  # at each tick the action called for; None for none
times = st.sampled_from([0.0, 0.05, 0.1, 0.3, 0.6, 1.0])  # [s]


class Script:
    """A method that calls for what it is told, tick by tick, and holds it as the others do."""

    name = "script"

    def __init__(self, actions, hold, clear):
        self._actions, self._latch = iter(actions), Latch(hold, clear)

    def reset(self, route):
        self._latch.reset()

    def propose(self, scene, decision):
        action = next(self._actions, None)
        return self._latch.settle(scene.time, CALM if action is None else Proposal(0.9, 0.5, action))


def steps_in(proposal):
    return proposal.score > proposal.threshold


def settled(actions, hold, clear):
    """What a latch makes of the actions, and the spells: places of the first tick and of the one after the last."""
    method = Script(actions, hold, clear)
    answers = [method.propose(scene_of([], place * TICK), None) for place in range(len(actions))]
    edges = [place for place, (a, b) in enumerate(itertools.pairwise([False, *map(steps_in, answers)])) if a != b]
    return answers, [*itertools.zip_longest(edges[::2], edges[1::2])]


@given(alarms, times, times)
def test_an_intervention_ends_as_soon_as_it_may_and_never_before(actions, hold, clear):
    _, spells = settled(actions, hold, clear)
    for begin, end in spells:
        assert actions[begin] is not None  # nobody steps in without a reason
        there = len(actions) if end is None else end
        quiet = next(place for place in range(there, -1, -1) if actions[place - 1] is not None)  # since this tick
        free = max(begin * TICK + hold, quiet * TICK + clear)
        if end is None:
            assert (len(actions) - 1) * TICK < free + SLACK or quiet == len(actions)
        else:
            assert actions[end] is None
            assert free - SLACK <= end * TICK < free + TICK + SLACK


@given(alarms, times, times)
def test_alarms_that_are_no_further_apart_than_the_release_asks_for_are_one_intervention(actions, hold, clear):
    _, spells = settled(actions, hold, clear)
    for (before, end), (again, _) in itertools.pairwise(spells):
        last = max(place for place in range(before, end) if actions[place] is not None)
        assert (again - last) * TICK > clear + SLACK
        assert (again - before) * TICK > hold + SLACK  # so that no more than so many can begin in a second


@given(alarms, times, times)
def test_what_is_held_does_not_change_between_two_alarms(actions, hold, clear):
    answers, _ = settled(actions, hold, clear)
    for place in range(1, len(actions)):
        if actions[place] is None and steps_in(answers[place]):
            assert answers[place].action == answers[place - 1].action


@pytest.mark.parametrize("parameters", [RssParameters(), PredictiveParameters()])
def test_the_rules_hold_for_a_while_unless_told_otherwise(parameters):
    assert parameters.hold >= 0.3
    assert parameters.clear >= 0.1


@pytest.mark.parametrize("policy", ["modular", "neural"])
def test_the_models_that_ship_do_not_let_go_at_the_first_quiet_frame(policy):
    assert AdreftModel.load(find_model(policy, "adreft-")).configuration.clear >= 0.1


def lagged(interval):
    """By how much engine and brake together can change the acceleration within an interval [s] [m/s2]."""
    brake = CAR.brake_max * (1.0 - math.exp(-interval / CAR.brake_lag))
    return brake + CAR.acceleration_max * (1.0 - math.exp(-interval / CAR.throttle_lag)) + 0.06  # of air and tyres


def driven(asked, called, hold=0.3, clear=0.1, speed=40.0):
    """Speeds [m/s] of a car that is driven through the guard by what the policy asks for, and what is called for."""
    car, route = LongitudinalDynamics(CAR, 1.0, speed), straight_route()
    repairer = GuardedRepairer(Script(called, hold, clear))
    repairer.reset(route)
    speeds, actions = [speed], []
    for place, action in enumerate(asked):
        scene = scene_of([], place * TICK, ego_at(speed=car.speed))
        repair = repairer.step(scene, Decision(Command.from_action(action), Trajectory.empty()))
        actions.append(repair.command.action)
        car.step(repair.command, TICK, 0.0)
        speeds.append(car.speed)
    return speeds, actions


def test_the_bound_is_that_of_the_actuators():
    assert lagged(WINDOW * TICK) / (WINDOW * TICK) <= JERK_MAX


@settings(deadline=None, max_examples=60)
@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.none() | braking), min_size=10, max_size=90), times, times)
def test_whatever_policy_and_method_do_the_jerk_is_no_more_than_the_actuators_can(ticks, hold, clear):
    asked, called = zip(*ticks, strict=True)
    speeds, actions = driven(asked, called, hold, clear)
    assert all(action <= wanted + 1e-12 for action, wanted in zip(actions, asked, strict=True))
    assert speeds[-1] > 0.0
    assert peaks(speeds)[1] <= JERK_MAX


def test_a_full_braking_out_of_full_throttle_comes_near_the_bound_and_its_release_stays_below_the_onset():
    onset, _ = driven([1.0] * 36, [None] * 20 + [-1.0] * 16, speed=15.0)
    assert peaks(onset)[1] > 0.7 * JERK_MAX
    released, _ = driven([1.0] * 24, [-1.0] * 8 + [None] * 16, speed=15.0)
    assert peaks(released[8:])[1] < peaks(onset)[1]


def test_an_alarm_that_flickers_is_one_onset_and_one_release():
    flicker = [None] * 10 + [-0.6, None] * 20 + [None] * 10
    _, actions = driven([0.5] * len(flicker), flicker)
    assert sum(a != b for a, b in itertools.pairwise(actions)) == 2
    _, bare = driven([0.5] * len(flicker), flicker, hold=0.0, clear=0.0)
    assert sum(a != b for a, b in itertools.pairwise(bare)) == 40
