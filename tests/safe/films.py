"""Films of vehicles on straight ways, for the tests of who judges them."""

import math

from roadmend.core.scene import EgoState, ObjectList
from roadmend.core.tick import INTERVAL
from roadmend.safe.film import Film
from roadmend.world.participants import Pose


def film_of(*vehicles, ticks=80, ego="v1"):
    """A film of vehicles given as name, place at the end [m], heading [deg] and speed [m/s]; the ego first."""
    film = Film(ego)
    for tick in range(ticks):
        left = (ticks - 1 - tick) * INTERVAL
        poses = {}
        for name, (x, y), heading, speed in vehicles:
            yaw = math.radians(heading)
            place = x - speed * left * math.cos(yaw), y - speed * left * math.sin(yaw)
            poses[name] = Pose(*place, math.remainder(yaw, math.tau), speed, 4.6, 1.8)
        own = poses.pop(ego)
        film.add(
            EgoState.from_yaw(own.x, own.y, own.yaw, own.speed, 0.0, own.length, own.width), ObjectList.empty(), poses
        )
    return film
