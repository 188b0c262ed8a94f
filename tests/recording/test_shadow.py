"""What a command asks of the vehicle; the comparison itself is tested on runs of the graph (tests/cli)."""

import pytest

from roadmend.core.command import Command
from roadmend.core.errors import InputError
from roadmend.recording.shadow import asked_acceleration, run_shadow
from roadmend.repair.registry import make_repairer
from roadmend.world.ego import LongitudinalDynamics, VehicleParameters


@pytest.mark.parametrize("speed", [5.0, 15.0, 30.0])
@pytest.mark.parametrize("action", [-1.0, -0.3, 0.0, 0.4, 1.0])
def test_asked_acceleration_is_what_the_vehicle_comes_to_without_resistance(speed, action):
    vehicle = VehicleParameters(drag=0.0, rolling=0.0, throttle_lag=1e-9, brake_lag=1e-9)
    dynamics = LongitudinalDynamics(vehicle, friction=5.0, speed=speed)
    dynamics.step(Command.from_action(action), 0.001, 0.0)
    assert asked_acceleration(Command.from_action(action), speed) == pytest.approx(dynamics.acceleration, abs=1e-6)


def test_a_bag_without_commands_cannot_be_judged():
    class Ticks:
        path, topics = "bag", ("ego", "objects", "route")

        def __iter__(self):
            return iter(())

    with pytest.raises(InputError, match="bag: holds no command of a policy or a repair node"):
        run_shadow(Ticks(), make_repairer("none"))
