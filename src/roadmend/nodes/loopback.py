"""How far the messages of a graph go: this machine, unless told otherwise.

ROS's discovery range says whom nodes look for. Fast DDS listens on every interface all the same, so that whoever finds
the port from outside is heard; where the range is this machine, its sockets are bound to the loopback interface too.
"""

import os
from pathlib import Path

RANGE = "ROS_AUTOMATIC_DISCOVERY_RANGE"  # environment variable: LOCALHOST, SUBNET, SYSTEM_DEFAULT or OFF
PROFILE = "FASTRTPS_DEFAULT_PROFILES_FILE"  # environment variable of Fast DDS; a file that is named there wins
HERE = "LOCALHOST"


def reach(default: str = HERE) -> dict[str, str]:
    """The environment of nodes that stay on this machine, or that reach as far as the user's environment says.

    Args:
        default: the discovery range where the environment names none.
    """
    chosen = os.environ.get(RANGE) or default
    if chosen != HERE or os.environ.get(PROFILE):
        return {RANGE: chosen}
    return {RANGE: chosen, PROFILE: str(Path(__file__).with_name("loopback.xml"))}
