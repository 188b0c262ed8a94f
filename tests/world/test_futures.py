import libsumo
import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.corpus import corpus_of
from roadmend.world.families import sample_scenario
from roadmend.world.futures import Moment, futures, moment_at, share_of_violations
from roadmend.world.runner import drive
from roadmend.world.scenario import Ego, Scenario
from roadmend.world.scenario_actors import Vehicle
from roadmend.world.scenario_networks import OpenRoadNetwork
from roadmend.world.simulation import Simulation
from roadmend.world.variation import Spread

AHEAD = 160  # ticks before the end at which the futures begin
NOTHING = Spread(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def violation():
    """The first of the corpus whose impact is hard."""
    cases = corpus_of("modular").select("S4", "test", violation=True)
    return next(case for case in cases if case.impact_speed > 6.0)


def driven(scenario, begin, *asked, repairer="none", horizon=12.0, **others):
    """What a scenario came to, and futures of the tick ``begin``, one list for each of ``asked`` seeds."""
    found = []
    with Simulation(scenario) as simulation:
        policy = make_policy("modular")

        def watch(tick, decision, _repair):
            if tick.number == begin:
                moment = Moment(simulation, tick, decision, policy)
                alone = make_repairer("none")
                alone.reset(simulation.route)
                found.extend(futures(moment, alone, seeds, horizon, **others) for seeds in asked)

        return drive(simulation, policy, make_repairer(repairer), watch), found


def test_the_episode_goes_on_as_if_nobody_had_looked_and_the_future_without_difference_is_what_will_be(violation):
    begin = round(violation.duration * 20) - AHEAD
    alone, _ = driven(violation.scenario(), -1)
    result, ((will_be,),) = driven(violation.scenario(), begin, [None])
    assert result == alone
    assert will_be.final == result.final
    assert will_be.duration == pytest.approx(0.05 * AHEAD)
    assert will_be.violates


def test_a_future_follows_from_its_seed_alone_and_seeds_differ(violation):
    begin = round(violation.duration * 20) - AHEAD
    _, (some, again, (third,)) = driven(violation.scenario(), begin, [1, 2, 3, 4], [4, 3, 2, 1], [3])
    assert some == again[::-1]
    assert third == some[2]
    assert len({(future.x, future.y) for future in some}) == 4


def test_a_spread_of_nothing_is_what_will_be():
    scenario = sample_scenario("S3", 4).model_copy(update={"time_limit": 8.0})
    _, ((will_be, same),) = driven(scenario, 60, [None, 7], spread=NOTHING)
    assert same == will_be


def test_beyond_the_horizon_nothing_counts(violation):
    begin = round(violation.duration * 20) - AHEAD
    _, (short,) = driven(violation.scenario(), begin, [1, 2], horizon=2.0)
    assert [future.final for future in short] == [None, None]
    assert [future.duration for future in short] == [2.0, 2.0]
    assert share_of_violations(short) == share_of_violations([]) == 0.0


def test_who_is_still_to_come_departs_at_another_time():
    scenario = next(
        scenario
        for scenario in (sample_scenario("S3", seed) for seed in range(50))
        if any(2.0 < actor.depart < 6.0 for actor in scenario.actors if actor.type == "vehicle")
    ).model_copy(update={"time_limit": 9.0})
    only = Spread(0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0)
    _, ((will_be, *others),) = driven(scenario, 20, [None, 1, 2, 3], spread=only)
    assert will_be.final is not None
    assert all(other.final is not None for other in others)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("speed", "at_least", "at_most"), [(5.0, 4.0, 6.0), (60.0, 15.0, 24.5)])
def test_who_is_still_to_come_keeps_the_speed_of_the_scenario_and_does_not_wait_for_room(
    seed, speed, at_least, at_most
):
    ahead = Vehicle(id="ahead", route=("forward",), position=30.0, speed=0.5, speed_factor=0.3, driver="careful")
    road = OpenRoadNetwork(length=600.0)
    late = Vehicle(id="late", kind="truck", route=("forward",), position=15.0, depart=2.0, speed=speed)
    ego = Ego(route=("forward",), position=300.0)
    with Simulation(Scenario(name="late", network=road, ego=ego, actors=(ahead, late), time_limit=60.0)) as simulation:
        simulation.first()
        simulation.step(Command(0.0, 1.0))
        simulation.vary(seed, Spread())
        while "late" not in libsumo.vehicle.getIDList():
            now = simulation.step(Command(0.0, 1.0)).scene.time
        assert now <= 2.0 + 2.0 * Spread().departure + 0.1
        entered = libsumo.vehicle.getSpeed("late")
    assert at_least < entered < at_most


def test_with_persons_and_a_repair_method_at_work(violation):
    scenario = next(
        scenario
        for scenario in (sample_scenario("S1", seed) for seed in range(100))
        if any(actor.type == "pedestrian" for actor in scenario.actors)
    ).model_copy(update={"time_limit": 6.0})
    result, ((will_be, *_),) = driven(scenario, 40, [None, 1])
    assert will_be.final == result.final
    with Simulation(violation.scenario()) as simulation:
        policy, found = make_policy("modular"), []
        begin = round(violation.duration * 20) - AHEAD

        def watch(tick, decision, _repair):
            if tick.number == begin:
                moment = Moment(simulation, tick, decision, policy)
                method = make_repairer("adreft")
                method.reset(simulation.route)
                found.extend(futures(moment, method, [None], 12.0))

        drive(simulation, policy, make_repairer("none"), watch)
    assert not found[0].violates


class Floored:
    """A policy of a user's, whose throttle is beyond all bounds."""

    name = "floored"

    def reset(self, route):
        pass

    def step(self, scene):
        return Decision(Command(2.5, 0.0), Trajectory.empty())


def test_an_invalid_command_moves_the_vehicle_as_where_it_is_driven():
    scenario = Scenario(name="s", network=OpenRoadNetwork(), ego=Ego(route=["forward"]), time_limit=3.0)
    speeds = []
    with Simulation(scenario) as simulation:
        drive(
            simulation,
            Floored(),
            make_repairer("none"),
            lambda tick, *_: speeds.append(tick.scene.ego.speed),
            lambda tick: speeds.append(tick.scene.ego.speed),
        )
    with Simulation(scenario) as simulation:
        alone = make_repairer("none")
        moment = moment_at(simulation, Floored(), alone, 40)
        (will_be,) = futures(moment, alone, [None], 12.0)
    assert moment.tick.scene.ego.speed == speeds[40]
    assert will_be.speed == speeds[-1] < 12.0
