"""The wheel: what it holds and asks for, and that it drives where there is no clone."""

import json
import os
import re
import runpy
import subprocess
import sys
import sysconfig
import tomllib
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest

import roadmend

REPOSITORY = Path(__file__).parents[2]
PROJECT = tomllib.loads((REPOSITORY / "pyproject.toml").read_text(encoding="utf-8"))
PREFIX = f"roadmend-{roadmend.__version__}"
SHARE = f"{PREFIX}.data/data/share/"

ASKED = "ROADMEND_TEST_WHEEL"
# To compile messages and kernels anew takes both processors for a minute; tests beside it that drive the graph fail then.
pytestmark = pytest.mark.skipif(not os.environ.get(ASKED), reason=f"compiles for a minute; set {ASKED}=1, run it alone")


def plain_environment():
    """That of a shell which knows nothing of this environment, so that a new one does not load its libraries."""
    environ = {key: value for key, value in os.environ.items() if not key.startswith(("AMENT", "ROS_", "_ROS"))}
    environ.pop("LD_LIBRARY_PATH", None)
    return {**environ, "PATH": os.pathsep.join([str(Path(sys.executable).parent), environ["PATH"]])}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Built with the tools of this environment: no network, and no second copy of ROS."""
    folder = tmp_path_factory.mktemp("wheel")
    options = ["--no-build-isolation", "--no-deps", "--no-index", "--wheel-dir", str(folder)]
    command = [sys.executable, "-m", "pip", "wheel", *options, str(REPOSITORY)]
    # The compiler runs alone and yields to everybody: tests beside it drive the graph, whose nodes answer in time.
    command = ["nice", "-n", "19", *command]
    environ = plain_environment() | {"CMAKE_BUILD_PARALLEL_LEVEL": "1"}
    result = subprocess.run(command, env=environ, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stdout[-3000:] + result.stderr[-3000:]
    (built,) = folder.iterdir()
    return built


@pytest.fixture(scope="module")
def content(wheel):
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """A new environment with the wheel; all other packages are lent by this environment."""
    folder = tmp_path_factory.mktemp("installed")
    environ = plain_environment()
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(folder)], env=environ, check=True)
    (site,) = (folder / "lib").glob("python*/site-packages")
    lent = [(site, path) for path in Path(sysconfig.get_path("purelib")).iterdir()]
    lent += [(folder / "lib", path) for path in Path(sys.prefix, "lib").glob("*.so*")]  # those of ROS
    for place, path in lent:
        if not path.name.removeprefix("lib").startswith(
            ("roadmend", "tf2_msgs", "vision_msgs")
        ):  # the wheel brings them
            (place / path.name).symlink_to(path)
    python = str(folder / "bin" / "python")
    pip = [sys.executable, "-m", "pip", "--python", python, "install", "--no-deps", "--no-index", str(wheel)]
    subprocess.run(pip, env=environ, check=True, capture_output=True)
    return folder


def call(installed, folder, *command):
    environ = plain_environment() | {"PATH": os.pathsep.join([str(installed / "bin"), os.environ["PATH"]])}
    return subprocess.run(command, cwd=folder, env=environ, capture_output=True, text=True, check=False)


@pytest.mark.slow
@pytest.mark.timeout(900)
class TestContent:
    def test_name_version_and_command(self, content):
        metadata = message_from_bytes(content[f"{PREFIX}.dist-info/METADATA"])
        assert (metadata["Name"], metadata["Version"]) == ("roadmend", roadmend.__version__)
        entry = f"roadmend = {PROJECT['project']['scripts']['roadmend']}"
        assert entry.encode() in content[f"{PREFIX}.dist-info/entry_points.txt"]

    def test_the_package_is_whole(self, content):
        source = REPOSITORY / "src"
        files = {
            path.relative_to(source).as_posix()
            for path in (source / "roadmend").rglob("*")
            if path.is_file() and "__pycache__" not in path.parts
        }
        assert {name for name in content if name.startswith("roadmend/")} == files

    def test_the_data_are_those_that_colcon_installs(self, content, monkeypatch):
        told = {}
        monkeypatch.setattr("setuptools.setup", lambda **settings: told.update(settings))
        runpy.run_path(str(REPOSITORY / "src" / "setup.py"))
        wanted = {f"{folder}/{Path(file).name}" for folder, files in told["data_files"] for file in files}
        ours = re.compile(r"share/(roadmend/.*|ament_index/resource_index/packages/roadmend)")
        names = {name.removeprefix(SHARE.removesuffix("share/")) for name in content if name.startswith(SHARE)}
        assert {name for name in names if ours.fullmatch(name)} == wanted

    def test_the_messages_are_built(self, content):
        for package in ("roadmend_msgs", "tf2_msgs", "vision_msgs"):
            assert SHARE + f"ament_index/resource_index/rosidl_interfaces/{package}" in content
            assert any(name.endswith(f"site-packages/{package}/__init__.py") for name in content)
            assert any(name.endswith(f"/lib/lib{package}__rosidl_typesupport_fastrtps_c.so") for name in content)

    def test_nothing_names_the_machine_that_built_it(self, content):
        places = [str(REPOSITORY).encode(), sys.prefix.encode(), b"/tmp/"]
        guilty = [
            (name, place)
            for name, data in content.items()
            for place in places
            if not name.startswith(("roadmend/", f"{PREFIX}.dist-info/", SHARE + "roadmend/")) and place in data
        ]
        assert guilty == []


@pytest.mark.slow
@pytest.mark.timeout(900)
class TestInstalled:
    def test_finds_its_data_and_definitions(self, installed, tmp_path):
        code = (
            "import json, roadmend; from roadmend.core.resources import config_folder;"
            "from roadmend.networks.checkpoint import models_folder; from roadmend.recording.definitions import find;"
            "find('roadmend_msgs/msg/RepairState'); find('tf2_msgs/msg/TFMessage');"
            "print(json.dumps([roadmend.__file__, str(config_folder()), str(models_folder())]))"
        )
        result = call(installed, tmp_path, "python", "-c", code)
        assert result.returncode == 0, result.stderr
        assert all(Path(place).is_relative_to(installed) for place in json.loads(result.stdout))

    @pytest.mark.graph
    def test_drives_in_the_graph_and_draws_what_it_recorded(self, installed, tmp_path):
        scenario = str(installed / "share" / "roadmend" / "config" / "scenarios" / "demo-exit.yaml")
        given = ["--repair", "adreft", "--name", "driven", "--json"]
        result = call(installed, tmp_path, "roadmend", "run", "--scenario", scenario, *given)
        assert result.returncode == 0, result.stderr
        (run,) = json.loads(result.stdout)
        assert run["outcome"] == "GOAL"
        drawn = call(installed, tmp_path, "roadmend", "bag", "plot", "bags/driven", "--out", "driven.png")
        assert drawn.returncode == 0, drawn.stderr
        assert (tmp_path / "driven.png").stat().st_size > 10_000

    def test_evaluates_what_ships(self, installed, tmp_path):
        scenario = str(installed / "share" / "roadmend" / "config" / "scenarios" / "demo-exit.yaml")
        given = ["--repair", "rss", "--workers", "1", "--out", "measured", "--json"]
        result = call(installed, tmp_path, "roadmend", "evaluate", scenario, *given)
        assert result.returncode == 0, result.stderr
        assert (tmp_path / "measured").is_dir()


def test_colcon_and_pip_describe_the_same_package():
    text = (REPOSITORY / "src" / "package.xml").read_text(encoding="utf-8")
    told = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("setuptools.setup", lambda **settings: told.update(settings))
        runpy.run_path(str(REPOSITORY / "src" / "setup.py"))
    project = PROJECT["project"]
    assert told["name"] == project["name"] == re.search("<name>(.+)</name>", text)[1]
    assert told["version"] == roadmend.__version__ == re.search("<version>(.+)</version>", text)[1]
    assert told["description"] == project["description"] == re.search("<description>(.+)</description>", text)[1]
    assert told["license"] == project["license"] == re.search("<license>(.+)</license>", text)[1]
    (command,) = project["scripts"].items()
    assert " = ".join(command) in told["entry_points"]["console_scripts"]


def pinned():
    """Every pin of the set-up, by its distribution's name as pip compares names."""
    files = (REPOSITORY / "config" / "requirements").glob("*.txt")
    lines = [line for path in files for line in path.read_text(encoding="utf-8").splitlines() if "==" in line]
    return {re.sub(r"[-_.]+", "-", name).lower(): version for name, version in (line.split("==") for line in lines)}


EVERY_NEED = [
    *PROJECT["project"]["dependencies"],
    *(need for name, needs in PROJECT["project"]["optional-dependencies"].items() if name != "all" for need in needs),
    *PROJECT["build-system"]["requires"],
]


@pytest.mark.parametrize("need", EVERY_NEED)
def test_the_set_up_pins_what_the_package_asks_for(need):
    from packaging.requirements import Requirement

    asked = Requirement(need)
    name = re.sub(r"[-_.]+", "-", asked.name).lower()
    if name == PROJECT["project"]["name"]:  # an extra that brings others of this package
        assert asked.extras <= set(PROJECT["project"]["optional-dependencies"])
    else:
        assert pinned()[name] in asked.specifier
