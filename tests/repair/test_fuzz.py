"""Whatever comes in, in any mixture of sense and nonsense: a valid command leaves that accelerates no more."""

import math
from random import Random

import numpy as np
import pytest

from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.repair import RepairStatus
from roadmend.repair.registry import METHODS, make_repairer

from .playground import Box, curved_route, ego_at, scene_of, straight_route, two_lane_route

ODD = [math.nan, math.inf, -math.inf, 0.0, -1.0, 1e-300, 1e7, -1e7, 1e300]


def value(numbers: Random, low: float, high: float, odd: float) -> float:
    return numbers.choice(ODD) if numbers.random() < odd else numbers.uniform(low, high)


@pytest.mark.parametrize("odd", [0.0, 0.01, 0.3])
@pytest.mark.parametrize("name", METHODS)
def test_a_valid_command_leaves(name, odd):
    numbers = Random(f"{name} {odd}")
    repairer = make_repairer(name)
    for tick in range(300):
        if tick % 60 == 0:
            repairer.reset(numbers.choice([straight_route(), curved_route(), two_lane_route()]))

        def draw(low, high):
            return value(numbers, low, high, odd)

        boxes = [
            Box(
                numbers.randrange(40),
                draw(-80.0, 80.0),
                draw(-20.0, 20.0),
                draw(-4.0, 4.0),
                draw(-1.0, 20.0),
                draw(-8.0, 3.0),
                draw(-0.6, 0.6),
                draw(0.3, 18.0),
                draw(0.3, 2.6),
            )
            for _ in range(numbers.randrange(12))
        ]
        ego = ego_at()._replace(x=draw(-90.0, 120.0), y=draw(-6.0, 6.0), yaw=draw(-3.1, 3.1), speed=draw(-0.5, 20.0))
        size = numbers.choice([0, 1, 2, 30])
        plan = Trajectory(
            draw(0.05, 0.5),
            *(np.array([draw(-50.0, 90.0) for _ in range(size)]) for _ in range(3)),
            np.array([draw(0.0, 20.0) for _ in range(size)]),
        )
        throttle = draw(0.0, 1.0) if numbers.random() < 0.5 else 0.0
        command = Command(throttle, draw(0.0, 1.0) if throttle == 0.0 else 0.0)
        repair = repairer.step(scene_of(boxes, 0.05 * tick, ego), Decision(command, plan))
        assert repair.command.fault == ""
        if not command.fault:
            assert repair.command.action <= command.action
        if odd == 0.0:
            assert repair.status not in {RepairStatus.MODEL_FAULT, RepairStatus.STALE_OBJECTS}, repair.reason
        else:
            assert "Error" not in repair.reason
