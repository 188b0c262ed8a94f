"""The set-up script: what it decides, what it says when something is missing, and that it can be interrupted."""

import ast
import fcntl
import os
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import SimpleNamespace

import pytest

from roadmend.cli import main

REPOSITORY = Path(__file__).parents[2]

# Runs the script of the current folder with one stage in place of the real ones: it notes that it ran, then sleeps.
DRIVER = """
import sys
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
loader = SourceFileLoader("launcher", "./roadmend")
launcher = module_from_spec(spec_from_loader("launcher", loader))
loader.exec_module(launcher)
def action(context):
    with open("ran", "a") as file:
        file.write("x")
    context.run(["sleep", sys.argv[1]])
launcher.stages = lambda context: [launcher.Stage("nap", context.stamp("nap"), "key", action)]
import os
os.makedirs(".venv", exist_ok=True)
try:
    launcher.set_up(launcher.Context(os.path.join(launcher.ROOT, ".venv")))
except KeyboardInterrupt:
    sys.exit(130)
"""


@pytest.fixture
def checkout(tmp_path):
    """A copy of what the set-up reads."""
    for name in ("roadmend", "config/requirements", "msg", "src/package.xml", "tests/npm/package-lock.json"):
        source, target = REPOSITORY / name, tmp_path / name
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copytree(source, target) if source.is_dir() else shutil.copy(source, target)
    return tmp_path


@pytest.fixture
def launcher(checkout):
    """The script as a module whose root is the copy."""
    loader = SourceFileLoader("launcher", str(checkout / "roadmend"))
    module = module_from_spec(spec_from_loader("launcher", loader))
    loader.exec_module(module)
    return module


@pytest.fixture
def context(launcher, checkout):
    (checkout / ".venv").mkdir()
    result = launcher.Context(str(checkout / ".venv"))
    result.lock = os.open(checkout, os.O_RDONLY)
    yield result
    os.close(result.lock)


def executable(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)
    return path


def plain_environment(**changes):
    """The environment of a user who has not yet met roadmend: no virtual environment, no pip settings."""
    environ = {
        name: value for name, value in os.environ.items() if not name.startswith(("PIP_", "AMENT", "ROS_", "_ROS"))
    }
    environ.pop("LD_LIBRARY_PATH", None)
    return {**environ, "PIP_CONFIG_FILE": os.devnull, **changes}


def test_every_python_since_3_6_can_read_the_script():
    ast.parse((REPOSITORY / "roadmend").read_text(), feature_version=(3, 6))


PINS = REPOSITORY / "config" / "requirements"
LISTS = sorted(path.stem for path in PINS.glob("*.txt"))


def pins_of(name):
    lines = (PINS / name).read_text().splitlines()
    pins = [line.removesuffix(" \\") for line in lines if not line.startswith(("#", " "))]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", pin) for pin in pins)
    return [re.sub(r"[-_.]+", "-", pin.split("==")[0].lower()) + "==" + pin.split("==")[1] for pin in pins]


@pytest.mark.parametrize("name", LISTS)
def test_pins_are_locked_to_digests_all_but_torch(name):
    locked = pins_of(name + ".lock")
    assert sorted(locked) == sorted(pin for pin in pins_of(name + ".txt") if not pin.startswith("torch=="))
    blocks = re.split(r"^(?=\S)", (PINS / f"{name}.lock").read_text(), flags=re.MULTILINE)[1:]
    assert len(blocks) == len(locked)
    assert all(re.search(r"--hash=sha256:[0-9a-f]{64}\b", block) for block in blocks)


def test_no_package_is_pinned_to_two_releases():
    pins = {pin for name in LISTS for pin in pins_of(name + ".txt")}
    names = [pin.split("==")[0] for pin in pins]
    assert len(names) == len(set(names))


def test_the_locks_name_no_place_on_the_network():
    assert not [path.name for path in PINS.iterdir() if re.search(r"https?://|index-url|find-links", path.read_text())]


def test_every_list_is_of_a_stage(launcher):
    assert set(LISTS) == {"base", "ros", "test", "uv", *launcher.EXTRAS}


def test_the_extras_are_those_of_the_package(launcher):
    project = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]
    assert {*launcher.EXTRAS, "all"} == set(project["optional-dependencies"])


class TestWhichPython:
    def test_takes_the_one_that_runs(self, launcher):
        assert Path(launcher.find_python(("{}.{}".format(*sys.version_info),))).exists()

    def test_looks_on_path_and_asks_each_candidate(self, launcher, tmp_path, monkeypatch):
        executable(tmp_path / "bin" / "python7.2", "#!/bin/sh\nexit 127\n")  # as a pyenv shim does
        good = executable(tmp_path / "bin" / "python7.1", "#!/bin/sh\necho 7.1\n")
        monkeypatch.setenv("PATH", str(tmp_path / "bin"))
        assert launcher.find_python(("7.2", "7.1")) == str(good)

    def test_says_in_one_line_that_there_is_none(self, launcher, monkeypatch, tmp_path):
        monkeypatch.setenv("PATH", str(tmp_path))
        with pytest.raises(
            launcher.SetupError, match=r"no Python 7\.2 or 7\.1 is on PATH; install one.*python7\.1-venv"
        ):
            launcher.find_python(("7.2", "7.1"))


class TestWhichRos:
    @pytest.fixture
    def installation(self, tmp_path):
        (tmp_path / "ros" / "share" / "rclpy").mkdir(parents=True)
        return str(tmp_path / "ros")

    def test_none(self, launcher):
        assert not launcher.jazzy_is_sourced({})

    def test_a_variable_alone_is_no_installation(self, launcher):
        assert not launcher.jazzy_is_sourced({"ROS_DISTRO": "humble"})

    def test_jazzy(self, launcher, installation):
        assert launcher.jazzy_is_sourced({"ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": "/nowhere:" + installation})

    def test_our_own_environment_is_no_installation(self, launcher, installation):
        Path(installation, "pyvenv.cfg").touch()
        assert not launcher.jazzy_is_sourced({"ROS_DISTRO": "jazzy", "AMENT_PREFIX_PATH": installation})

    def test_another_distribution_is_refused(self, launcher, installation):
        with pytest.raises(launcher.SetupError, match="sourced ROS 2 humble"):
            launcher.jazzy_is_sourced({"ROS_DISTRO": "humble", "AMENT_PREFIX_PATH": installation})

    def test_with_jazzy_the_wheels_of_ros_are_left_out(self, launcher, checkout, monkeypatch):
        installed = []
        monkeypatch.setattr(launcher, "install", lambda context, *names: installed.append(names))
        for jazzy in (False, True):
            context = launcher.Context(str(checkout / ".venv"), jazzy=jazzy)
            launcher.stages(context)[1].action(context)
        assert installed == [("base", "ros"), ("base",)]

    def test_with_jazzy_messages_of_a_sourced_workspace_are_taken(self, launcher, context, monkeypatch):
        built = []
        monkeypatch.setattr(launcher, "build_package", lambda _, source, __: built.append(Path(source).name))
        monkeypatch.setattr(launcher, "build_tools_missing", lambda _: "")
        monkeypatch.setattr(launcher, "provided", lambda _, package: package == "tf2_msgs")
        context.jazzy = True
        launcher.build_messages(context)
        assert built == ["vision_msgs", "msg"]
        monkeypatch.setattr(launcher, "provided", lambda *_: True)
        launcher.build_messages(context)
        assert built == ["vision_msgs", "msg"]


class TestEnvironment:
    def test_libraries_of_another_environment_are_dropped_and_the_users_kept(self, context, tmp_path, monkeypatch):
        (tmp_path / "other" / "lib").mkdir(parents=True)
        (tmp_path / "other" / "pyvenv.cfg").touch()
        monkeypatch.setenv("_ROS_WHEELS_BOOTSTRAP_COMPLETE", "1")
        folders = [str(tmp_path / "other" / "lib"), "/x/site-packages/ros_rclpy.libs", "/usr/local/cuda/lib"]
        monkeypatch.setenv("LD_LIBRARY_PATH", ":".join(folders))
        result = context.environment()
        assert result["LD_LIBRARY_PATH"] == "/usr/local/cuda/lib"
        assert "_ROS_WHEELS_BOOTSTRAP_COMPLETE" not in result

    def test_what_the_user_set_stays(self, context, monkeypatch):
        monkeypatch.setenv("ROS_LOG_DIR", "/elsewhere")
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "SUBNET")
        monkeypatch.setenv("AMENT_PREFIX_PATH", "/overlay")
        result = context.environment()
        assert (result["ROS_LOG_DIR"], result["ROS_AUTOMATIC_DISCOVERY_RANGE"]) == ("/elsewhere", "SUBNET")
        assert result["AMENT_PREFIX_PATH"] == context.venv + ":/overlay"

    def test_defaults(self, context, monkeypatch):
        for name in ("ROS_LOG_DIR", "ROS_AUTOMATIC_DISCOVERY_RANGE", "AMENT_PREFIX_PATH"):
            monkeypatch.delenv(name, raising=False)
        result = context.environment()
        assert result["ROS_LOG_DIR"].startswith(context.venv)
        assert result["ROS_AUTOMATIC_DISCOVERY_RANGE"] == "LOCALHOST"
        assert result["AMENT_PREFIX_PATH"] == context.venv


class TestOneLineErrors:
    def test_no_compiler(self, launcher, context, monkeypatch, tmp_path):
        monkeypatch.setenv("PATH", str(tmp_path))
        monkeypatch.delenv("CXX", raising=False)
        with pytest.raises(launcher.SetupError, match=r"^no C\+\+ compiler found; .*apt install build-essential$"):
            launcher.build_messages(context)

    def test_no_c_compiler(self, launcher, context, monkeypatch, tmp_path):
        executable(tmp_path / "g++", "#!/bin/sh\n")
        monkeypatch.setenv("PATH", str(tmp_path))
        monkeypatch.delenv("CXX", raising=False)
        monkeypatch.delenv("CC", raising=False)
        with pytest.raises(launcher.SetupError, match="no C compiler found"):
            launcher.build_messages(context)

    def test_the_compiler_that_the_user_chose_is_missing(self, launcher, context, monkeypatch):
        monkeypatch.setenv("CXX", "no-such-compiler -O2")
        with pytest.raises(launcher.SetupError, match="under the name CXX=no-such-compiler"):
            launcher.build_messages(context)

    def test_no_python_headers(self, launcher, context, monkeypatch):
        monkeypatch.setattr(context, "run", lambda _: "/usr/include/python3.12\n")
        monkeypatch.setattr(os.path, "exists", lambda _: False)
        monkeypatch.setattr(shutil, "which", lambda name: "/usr/bin/" + name)
        assert "apt install python3.12-dev" in launcher.build_tools_missing(context)

    def test_no_venv_module(self, launcher, context, monkeypatch, tmp_path):
        text = "#!/bin/sh\necho 'virtual environment was not created because ensurepip is not available'\nexit 1\n"
        python = executable(tmp_path / "python9", text)
        monkeypatch.setattr(launcher, "find_python", lambda _: str(python))
        with pytest.raises(launcher.SetupError, match="has no venv module; install it: sudo apt install python3-venv"):
            launcher.make_venv(context)

    def test_disk_too_small(self, launcher, context, monkeypatch):
        usage = SimpleNamespace(free=10**8)
        monkeypatch.setattr(shutil, "disk_usage", lambda _: usage)
        with pytest.raises(launcher.SetupError, match=r"^100 MB are free in .*make room"):
            launcher.install(context, "base")

    def test_disk_full_meanwhile(self, context):
        error = context.error("OSError: [Errno 28] No space left on device", "pip failed", "try again")
        assert "the disk is full; make room" in str(error)

    def test_unwritable_folder(self, launcher, context, monkeypatch):
        monkeypatch.setattr(os, "access", lambda *_: False)
        with pytest.raises(launcher.SetupError, match="cannot write in"):
            launcher.set_up(context)

    def test_wrong_machine(self, launcher, context, monkeypatch):
        monkeypatch.setattr(os, "uname", lambda: SimpleNamespace(machine="aarch64"))
        with pytest.raises(launcher.SetupError, match="Linux on x86_64 only"):
            launcher.set_up(context)

    @pytest.mark.parametrize(
        ("output", "what"),
        [
            ("WARNING: Retrying: NewConnectionError\nERROR: No matching distribution found for x==1", "cannot reach"),
            ("ERROR: No matching distribution found for ros-rclpy==7.1.6", "finds no ros-rclpy==7.1.6"),
            ("ERROR: something else", "pip failed"),
        ],
    )
    def test_pip(self, launcher, output, what):
        assert what in launcher.explain_pip(output)[0]

    def test_a_library_of_the_system_is_missing(self, launcher, context, monkeypatch):
        def fail(_):
            raise RuntimeError("Traceback\nImportError: libGL.so.1: cannot open shared object file")

        monkeypatch.setattr(context, "run", fail)
        with pytest.raises(launcher.SetupError, match=r"libGL\.so\.1.*apt install .*libgl1"):
            launcher.try_imports(context)

    def test_an_index_out_of_reach_from_the_first_call_on(self, checkout):
        environ = plain_environment(PIP_INDEX_URL="http://127.0.0.1:9/simple", PIP_RETRIES="1", PIP_NO_CACHE_DIR="1")
        command = [getattr(sys, "_base_executable", sys.executable), str(checkout / "roadmend"), "--help"]
        first = subprocess.run(command, env=environ, capture_output=True, text=True, check=False)
        assert first.returncode == 2
        assert "Traceback" not in first.stderr
        assert "Python environment" in first.stderr
        last = first.stderr.splitlines()[-1]
        log = checkout / ".venv" / "setup.log"
        assert last.startswith("roadmend: pip cannot reach its package index; check the network")
        assert last.endswith(f"(details: {log})")
        assert "127.0.0.1" in log.read_text()
        assert [path.name for path in (checkout / ".venv" / "stamps").iterdir()] == ["venv"]
        # The next call goes on with what failed.
        second = subprocess.run(command, env=environ, capture_output=True, text=True, check=False)
        assert second.returncode == 2
        assert "Python environment" not in second.stderr


class TestExtras:
    @pytest.mark.parametrize(
        ("command", "needed"),
        [
            ("", ""),
            ("demo", ""),
            ("run train", ""),
            ("evaluate x.yaml --repair rss", ""),
            ("evaluate x.yaml --page", "reports"),
            ("bag info x", ""),
            ("bag plot x", "reports"),
            ("run --scenario s.yaml --foxglove", "foxglove"),
            ("run --foxglove=9000", "foxglove"),
            ("safe export x", "export language reading reports sketch"),
            ("sera analyse x", "language reports sera"),
            ("faults --out x --page", "reports"),
            ("train", ""),
            ("safe", ""),
            ("safe extrct x", ""),
            ("train adreft --seed 3", "training"),
            ("train reader told.jsonl", "reading training"),
            ("sera cycle", "language reports sera training"),
            ("bench sera", "export foxglove language reading reports sera sketch training"),
            ("train --help", ""),
            ("safe extract -h", ""),
            ("set-up", ""),
            ("set-up training sera", "training sera"),
            ("set-up rl gym", "rl gym pandas training"),
            ("set-up sketch", "sketch reports"),
        ],
    )
    def test_come_with_the_commands_that_need_them(self, launcher, command, needed):
        assert launcher.extras_needed(command.split()) == tuple(needed.split())

    def test_commands_of_groups_are_those_that_there_are(self, launcher):
        tables = {group.name: group.table for group in (main.safe, main.sera, main.train)}
        benchmarks = subprocess.run(
            [sys.executable, REPOSITORY / "tests" / "benchmarks" / "bench.py", "--help"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        tables["bench"] = re.findall(r"^  ([a-z]+)  ", benchmarks.partition("Commands:")[2], re.MULTILINE)
        assert {name: sorted(table) for name, table in tables.items()} == launcher.GROUPS

    def test_what_one_works_with_besides_is_what_the_package_says(self, launcher):
        extras = tomllib.loads((REPOSITORY / "pyproject.toml").read_text())["project"]["optional-dependencies"]
        named = {name: re.findall(r"^roadmend\[(.+)\]$", needs[0]) for name, needs in extras.items() if name != "all"}
        assert {name: tuple(more[0].split(",")) for name, more in named.items() if more} == launcher.ALSO

    def test_one_that_is_not_there_is_named_with_those_that_are(self, launcher):
        with pytest.raises(launcher.SetupError, match=r"set-up trainng: there is no such.* choose of .*training, test"):
            launcher.extras_needed(["set-up", "trainng"])

    def test_the_tests_need_all(self, launcher, context):
        assert launcher.Context(context.venv, testing=True).extras == [*launcher.EXTRAS]
        assert context.extras == []


class TestKeptMessages:
    """What one clone has built another takes, if it is made of the same and for the same."""

    @pytest.fixture
    def clone(self, launcher, checkout, tmp_path, monkeypatch):
        """Builds the messages of a clone, in place of the compiler; gives what was built and what lies there then."""
        monkeypatch.setenv("ROADMEND_CACHE", str(tmp_path / "cache"))
        monkeypatch.setattr(launcher, "build_tools_missing", lambda _: "")
        built = []

        def build_package(context, _source, build):
            name = Path(build).name
            built.append(name)
            files = [Path(context.venv, "lib", f"lib{name}.so"), Path(context.venv, "share", name, "setup.sh")]
            for file in files:
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(f"of {context.venv}\n")
            Path(build).parent.mkdir(exist_ok=True)
            Path(build + ".installed").write_text("\n".join(map(str, files)))

        monkeypatch.setattr(launcher, "build_package", build_package)

        def make(name, version="3.11.7"):
            venv = checkout / name
            venv.mkdir()
            (venv / "pyvenv.cfg").write_text(f"home = /usr/bin\nversion = {version}\n")
            built.clear()
            launcher.build_messages(launcher.Context(str(venv)))
            return list(built), (venv / "share" / "roadmend_msgs" / "setup.sh").read_text()

        return make

    def test_the_second_clone_takes_them_under_its_own_prefix(self, clone, checkout):
        names = ["tf2_msgs", "vision_msgs", "roadmend_msgs"]
        assert clone("first") == (names, f"of {checkout / 'first'}\n")
        assert clone("second") == ([], f"of {checkout / 'second'}\n")
        assert (checkout / "second" / "lib" / "libtf2_msgs.so").is_file()
        assert str(checkout / "first") not in (checkout / "second" / "build" / "tf2_msgs.installed").read_text()

    def test_other_messages_or_another_python_are_built(self, clone, checkout):
        clone("first")
        assert clone("second", "3.12.1")[0]
        with (checkout / "msg" / "msg" / "Command.msg").open("a") as file:
            file.write("float64 more\n")
        assert clone("third")[0]

    def test_what_is_damaged_is_built_and_kept_anew(self, clone, tmp_path):
        clone("first")
        (kept,) = (tmp_path / "cache" / "messages").iterdir()
        data = bytearray(kept.read_bytes())
        data[60] ^= 255
        kept.write_bytes(data)
        assert clone("second")[0]
        assert clone("third")[0] == []

    def test_no_place_to_keep_them_is_no_error(self, clone, tmp_path):
        (tmp_path / "cache").touch()
        assert clone("first")[0]


class TestInstaller:
    @pytest.fixture
    def commands(self, launcher, context, monkeypatch):
        """What would have been run; pip's settings are asked for by running it, and it has some."""
        result = []

        def run(command, settings=None, cwd=None):
            result.append((command, settings))
            return "global.index-url='http://here/simple'\nglobal.timeout='9'\n:env:.find-links='/a\\n/b'\n"

        monkeypatch.setattr(context, "run", run)
        monkeypatch.delenv("UV_DEFAULT_INDEX", raising=False)
        monkeypatch.delenv("UV_FIND_LINKS", raising=False)
        return result

    def test_uv_of_the_user_is_taken_and_told_what_pip_is_told(self, launcher, context, commands, monkeypatch):
        monkeypatch.setattr(shutil, "which", lambda name: "/usr/bin/" + name)
        launcher.install(context, "base", "ros")
        command, settings = commands[-1]
        assert command[:5] == ["/usr/bin/uv", "pip", "install", "--python", context.python]
        assert "--require-hashes" in command
        assert [Path(part).name for part in command if part.endswith(".lock")] == ["base.lock", "ros.lock"]
        assert settings == {
            "UV_DEFAULT_INDEX": "http://here/simple",
            "UV_FIND_LINKS": "/a,/b",
            "UV_INDEX_STRATEGY": "unsafe-best-match",
        }

    def test_what_the_user_told_uv_wins(self, launcher, context, commands, monkeypatch):
        monkeypatch.setenv("UV_DEFAULT_INDEX", "http://there/simple")
        monkeypatch.setenv("UV_INDEX_STRATEGY", "first-index")
        assert launcher.uv_settings(context) == {"UV_FIND_LINKS": "/a,/b"}

    def test_where_there_is_none_pip_fetches_one_once_and_it_goes_again(self, launcher, context, commands, monkeypatch):
        monkeypatch.setattr(shutil, "which", lambda _: None)
        launcher.install(context, "base")
        launcher.install(context, "test")
        fetched = [command for command, _ in commands if any(part.endswith("uv.lock") for part in command)]
        assert len(fetched) == 1
        assert "--require-hashes" in fetched[0]
        assert fetched[0][fetched[0].index("--target") + 1] == context.tools
        assert commands[-1][0][0] == f"{context.tools}/bin/uv"

    def test_pip_does_it_where_no_uv_can_be_had_or_uv_fails(self, launcher, context, monkeypatch):
        commands = []

        def run(command, settings=None, cwd=None):
            commands.append(command)
            if any("uv" in Path(part).name for part in command):
                raise RuntimeError("no uv for this machine")
            return ""

        monkeypatch.setattr(context, "run", run)
        for found in (None, "/usr/bin/uv"):
            context.uv = context.tools = ""
            monkeypatch.setattr(shutil, "which", lambda _, found=found: found)
            launcher.install(context, "base")
            assert commands[-1][:4] == [context.python, "-m", "pip", "install"]
            assert "--require-hashes" in commands[-1]

    def test_torch_comes_from_pip_with_its_dependencies_and_by_its_exact_release(
        self, launcher, context, commands, monkeypatch
    ):
        monkeypatch.setattr(shutil, "which", lambda name: "/usr/bin/" + name)
        launcher.install_training(context)
        (pip,) = [command for command, _ in commands if "torch==2.13.0" in command]
        assert pip[:4] == [context.python, "-m", "pip", "install"]
        assert "--no-deps" not in pip
        assert [Path(pip[place + 1]).name for place, part in enumerate(pip) if part == "-c"] == [
            "training.txt",
            "base.txt",
        ]
        assert "import torch" in commands[-1][0][-1]

    def test_a_failure_names_the_smaller_build(self, launcher, context, monkeypatch):
        monkeypatch.setattr(launcher, "install", lambda *_: None)

        def fail(_):
            raise RuntimeError("OSError: [Errno 28] No space left on device")

        monkeypatch.setattr(context, "run", fail)
        with pytest.raises(launcher.SetupError, match=r"the disk is full; make room.*a CPU build of the torch"):
            launcher.install_training(context)


class TestStamps:
    @pytest.fixture
    def ready(self, launcher, context, checkout):
        """A set-up that claims to be complete, with a Python that says how it was called."""
        executable(checkout / ".venv" / "bin" / "python", '#!/bin/sh\necho "$@"\n')
        (checkout / "src" / "roadmend").mkdir()
        for stage in launcher.stages(context):
            stage.mark()
        return checkout

    @staticmethod
    def open_stages(launcher, context):
        return [stage.title.split(" (")[0] for stage in launcher.stages(context) if not stage.done()]

    def test_a_later_call_becomes_the_command_at_once(self, ready):
        command = [sys.executable, str(ready / "roadmend"), "drive", "--seed", "7"]
        result = subprocess.run(command, env=plain_environment(), capture_output=True, text=True, check=False)
        assert (result.stdout, result.stderr) == ("-P -m roadmend.cli drive --seed 7\n", "")

    def test_a_new_message_rebuilds_the_messages_alone(self, ready, launcher, context):
        (ready / "msg" / "msg" / "New.msg").write_text("bool new\n")
        assert self.open_stages(launcher, context) == ["ROS messages", "first start"]

    def test_a_new_pin_reinstalls_the_packages(self, ready, launcher, context):
        with (ready / "config" / "requirements" / "base.lock").open("a") as file:
            file.write("six==1.17.0\n")
        assert self.open_stages(launcher, context) == ["packages", "first start", "numerical kernels"]

    def test_new_ros_wheels_rebuild_the_messages_too(self, ready, launcher, context):
        with (ready / "config" / "requirements" / "ros.lock").open("a") as file:
            file.write("six==1.17.0\n")
        assert self.open_stages(launcher, context) == ["packages", "ROS messages", "first start"]

    def test_another_python_begins_anew(self, ready, launcher, context):
        (ready / ".venv" / "bin" / "python").unlink()
        (ready / ".venv" / "bin" / "python").symlink_to(sys.executable)
        assert self.open_stages(launcher, context)[0] == "Python environment"

    def test_so_does_one_that_was_taken_away(self, ready, launcher, context):
        python = ready / ".venv" / "bin" / "python"
        python.unlink()
        python.symlink_to(sys.executable)
        for stage in launcher.stages(context):
            stage.mark()
        assert self.open_stages(launcher, context) == []
        gone = ready / "python3.11"
        gone.symlink_to(sys.executable)
        python.unlink()
        python.symlink_to(gone)
        for stage in launcher.stages(context):
            stage.mark()
        gone.rename(ready / "elsewhere")
        assert self.open_stages(launcher, context)[0] == "Python environment"

    def test_an_image_is_set_up_before_the_code_is_there_and_the_kernels_after_it(self, ready, launcher, context):
        (ready / "src" / "roadmend").rmdir()
        assert "numerical kernels" not in [stage.title for stage in launcher.stages(context)]
        text = (REPOSITORY / "docker" / "Dockerfile").read_text()
        first, between, last = text.partition("COPY --chown=1001:1001 . .")
        assert "RUN ./roadmend set-up" in first
        assert between
        assert "RUN ./roadmend set-up" in last
        copied = {line.split()[-2] for line in first.splitlines() if line.startswith("COPY")}
        assert copied == {
            "roadmend",
            "config/requirements",
            "msg",
            "src/package.xml",
        }  # of which ``checkout`` is a copy

    def test_testing_adds_its_own_stages(self, ready, launcher, context, monkeypatch):
        monkeypatch.setattr(launcher, "node_found", lambda: True)
        context = launcher.Context(context.venv, testing=True)
        added = [title.split(" (")[0] for title, _ in launcher.EXTRAS.values()] + ["test tools"]
        assert self.open_stages(launcher, context) == [*added, "JavaScript readers"]
        monkeypatch.setattr(launcher, "node_found", lambda: False)
        assert self.open_stages(launcher, context) == added

    def test_every_stage_installs_its_own_list(self, launcher, context, monkeypatch):
        installed = []
        monkeypatch.setattr(launcher, "install", lambda _, *names: installed.append(names))
        for stage in launcher.stages(launcher.Context(context.venv, testing=True)):
            if stage.action.__name__ == "<lambda>":  # the others do more than that
                stage.action(context)
        extras = [(name,) for name in launcher.EXTRAS if name != "training"]
        assert installed == [("base", "ros"), *extras, ("test",)]

    def test_training_adds_torch_alone(self, ready, launcher, context):
        context = launcher.Context(context.venv, extras=("training",))
        assert self.open_stages(launcher, context) == ["torch, for training"]

    def test_another_torch_is_installed_where_it_is_needed_and_nowhere_else(self, ready, launcher, context):
        training = launcher.Context(context.venv, extras=("training",))
        launcher.stages(training)[-1].mark()
        assert self.open_stages(launcher, training) == []
        with (ready / "config" / "requirements" / "training.txt").open("a") as file:
            file.write("six==1.17.0\n")
        assert self.open_stages(launcher, training) == ["torch, for training"]
        assert self.open_stages(launcher, context) == []


class TestSeveralCalls:
    def start(self, checkout, seconds):
        command = [sys.executable, "-c", DRIVER, str(seconds)]
        return subprocess.Popen(command, cwd=checkout, env=plain_environment(), stderr=subprocess.PIPE, text=True)

    def wait_for_the_stage(self, checkout):
        end = time.monotonic() + 10
        while not (checkout / "ran").exists() and time.monotonic() < end:
            time.sleep(0.01)
        time.sleep(0.1)  # from the note to the program that it runs

    def test_two_at_once_do_the_work_once(self, checkout):
        first = self.start(checkout, 1)
        self.wait_for_the_stage(checkout)
        second = self.start(checkout, 1)
        assert "waiting for it" in second.communicate()[1]
        first.communicate()
        assert (first.returncode, second.returncode) == (0, 0)
        assert (checkout / "ran").read_text() == "x"

    def test_an_interrupted_stage_leaves_no_stamp(self, checkout):
        process = self.start(checkout, 60)
        self.wait_for_the_stage(checkout)
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=30)
        assert process.returncode == 130
        assert not (checkout / ".venv" / "stamps").exists()
        again = self.start(checkout, 0)
        again.communicate(timeout=30)
        assert again.returncode == 0
        assert (checkout / ".venv" / "stamps" / "nap").read_text() == "key"

    def test_what_a_killed_call_left_running_is_waited_for(self, checkout):
        process = self.start(checkout, 2)
        self.wait_for_the_stage(checkout)
        process.kill()
        process.wait()
        folder = os.open(checkout, os.O_RDONLY)
        try:
            with pytest.raises(BlockingIOError):
                fcntl.flock(folder, fcntl.LOCK_EX | fcntl.LOCK_NB)
            fcntl.flock(folder, fcntl.LOCK_EX)
        finally:
            os.close(folder)
