"""How the nodes of a benchmark are started beside those of roadmend."""

import os
from pathlib import Path

_FOLDER = Path(__file__).parents[1]  # where "harness" is found


def node_environment(domain: int) -> dict[str, str]:
    """The environment of a node's process: a ROS domain for itself, and this folder among the places to import from."""
    path = os.pathsep.join([str(_FOLDER), *filter(None, [os.environ.get("PYTHONPATH")])])
    own = {"ROS_DOMAIN_ID": str(domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST", "PYTHONPATH": path}
    return os.environ | own
