"""roadmend as a ROS 2 package (ament_python), for colcon."""

import os
import re
from pathlib import Path

from setuptools import find_packages, setup

NAME = "roadmend"
HERE = Path(__file__).resolve().parent
VERSION = re.search(r'__version__ = "(.+)"', (HERE / NAME / "__init__.py").read_text(encoding="utf-8"))[1]


def configuration() -> list[tuple[str, list[str]]]:
    """List the files of the folder config beside src as (target folder, files), for the package's share folder."""
    # setuptools wants paths relative to the folder that it runs in, and colcon may run it through a symlink.
    source = HERE.parent / "config"
    folders: dict[str, list[str]] = {}
    for path in sorted(source.rglob("*")):
        if path.is_file() and "requirements" not in path.parts:
            target = Path("share", NAME, "config", path.relative_to(source).parent)
            folders.setdefault(str(target), []).append(os.path.relpath(path, HERE))
    return list(folders.items())


def definitions() -> list[tuple[str, list[str]]]:
    """List the files of the message definitions beside src likewise: the offline commands need no installed ones."""
    messages = HERE.parent / "msg"
    packages = [
        (NAME + "_msgs", messages),
        *((path.name, path) for path in sorted((messages / "vendor").glob("*_msgs"))),
    ]
    return [
        (
            f"share/{NAME}/msg/{package}",
            [os.path.relpath(path, HERE) for path in sorted((folder / "msg").glob("*.msg"))],
        )
        for package, folder in packages
    ]


setup(
    name=NAME,
    version=VERSION,
    packages=find_packages(include=[NAME, NAME + ".*"]),
    package_data={"": ["py.typed", "*.pyi", "*.json", "*.md", "*.png", "*.txt", "*.yaml", "*.xml", "templates/*.html"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + NAME]),
        ("share/" + NAME, ["package.xml"]),
        (f"share/{NAME}/launch", sorted(os.path.relpath(path, HERE) for path in (HERE / "launch").glob("*.launch.py"))),
        *configuration(),
        *definitions(),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    maintainer="The roadmend maintainers",
    maintainer_email="maintainers@roadmend.invalid",
    description="Repairs a driving policy while it drives, and learns from what went wrong.",
    license="Apache-2.0",
    entry_points={
        "gymnasium.envs": ["roadmend = roadmend.gym:register"],
        "console_scripts": [
            "roadmend = roadmend.cli.entry:main",
            "sim_node = roadmend.nodes.sim:main",
            "policy_node = roadmend.nodes.policy:main",
            "repair_node = roadmend.nodes.repair:main",
            "recorder_node = roadmend.nodes.recorder:main",
            "viz_node = roadmend.nodes.viz:main",
            "foxglove_node = roadmend.nodes.foxglove:main",
            "replay_node = roadmend.nodes.replay:main",
            "safe_node = roadmend.nodes.safe:main",
            "sera_node = roadmend.nodes.sera:main",
        ],
    },
)
