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
from importlib.machinery import SourceFileLoader
from importlib.util import module_from_spec, spec_from_loader
from pathlib import Path
from types import SimpleNamespace

import pytest

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


@pytest.mark.parametrize("name", ["base.txt", "export.txt", "ros.txt", "test.txt", "train.txt"])
def test_pins_are_complete_and_exact(name):
    lines = (REPOSITORY / "config" / "requirements" / name).read_text().splitlines()
    pins = [line for line in lines if not line.startswith("#")]
    assert all(re.fullmatch(r"[\w.-]+==[\w.]+", pin) for pin in pins)
    names = [re.sub(r"[-_.]+", "-", pin.split("==")[0].lower()) for pin in pins]
    assert len(names) == len(set(names))


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
        assert installed == [("base.txt", "ros.txt"), ("base.txt",)]

    def test_with_jazzy_messages_of_a_sourced_workspace_are_taken(self, launcher, context, monkeypatch):
        built = []
        monkeypatch.setattr(launcher, "build_package", lambda _, source, __: built.append(Path(source).name))
        monkeypatch.setattr(launcher, "build_tools_missing", lambda _: "")
        monkeypatch.setattr(launcher, "provided", lambda _, package: package == "tf2_msgs")
        context.jazzy = True
        launcher.build_messages(context)
        assert built == ["msg"]
        monkeypatch.setattr(launcher, "provided", lambda *_: True)
        launcher.build_messages(context)
        assert built == ["msg"]


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
            launcher.install(context, "base.txt")

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


class TestTorch:
    @pytest.mark.parametrize(
        "command",
        [
            "train",
            "train adreft --seed 3",
            "bench adreft --quick",
            "bench sera",
            "sera cycle",
            "sera tune",
            "set-up train",
        ],
    )
    def test_is_installed_for_what_trains_or_measures_against_it(self, launcher, command):
        assert launcher.needs_torch(command.split())

    @pytest.mark.parametrize(
        "command", ["", "demo", "run train", "bench loop", "sera analyse", "set-up", "train --help", "train x -h"]
    )
    def test_and_for_nothing_else(self, launcher, command):
        assert not launcher.needs_torch(command.split())

    def test_the_tests_need_it_too(self, launcher, context):
        assert launcher.Context(context.venv, testing=True).training
        assert not context.training

    def test_is_asked_for_with_its_dependencies_and_by_its_exact_release(self, launcher, context, monkeypatch):
        commands = []
        monkeypatch.setattr(context, "run", commands.append)
        launcher.install_torch(context)
        pip = commands[0]
        assert "--no-deps" not in pip
        assert not any(part.startswith("torch") for part in pip)
        lists = [Path(pip[place + 1]).name for place, part in enumerate(pip) if part in {"-r", "-c"}]
        assert lists == ["train.txt", "base.txt"]
        pins = (Path(pip[pip.index("-r") + 1])).read_text().splitlines()
        assert [pin for pin in pins if pin.startswith("torch")] == ["torch==2.13.0"]
        assert "import torch" in commands[1][-1]

    def test_pins_agree_with_those_that_it_is_installed_beside(self):
        folder = REPOSITORY / "config" / "requirements"
        names = [
            line.split("==")[0].lower()
            for name in ("base.txt", "export.txt", "ros.txt", "test.txt", "train.txt")
            for line in (folder / name).read_text().splitlines()
            if "==" in line
        ]
        assert len(names) == len(set(names))

    def test_a_failure_names_the_smaller_build(self, launcher, context, monkeypatch):
        def fail(_):
            raise RuntimeError("OSError: [Errno 28] No space left on device")

        monkeypatch.setattr(context, "run", fail)
        with pytest.raises(launcher.SetupError, match=r"the disk is full; make room.*a CPU build of the torch"):
            launcher.install_torch(context)


class TestStamps:
    @pytest.fixture
    def ready(self, launcher, context, checkout):
        """A set-up that claims to be complete, with a Python that says how it was called."""
        executable(checkout / ".venv" / "bin" / "python", '#!/bin/sh\necho "$@"\n')
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
        with (ready / "config" / "requirements" / "base.txt").open("a") as file:
            file.write("six==1.17.0\n")
        assert self.open_stages(launcher, context) == ["packages", "first start", "numerical kernels"]

    def test_new_ros_wheels_rebuild_the_messages_too(self, ready, launcher, context):
        with (ready / "config" / "requirements" / "ros.txt").open("a") as file:
            file.write("six==1.17.0\n")
        assert self.open_stages(launcher, context) == ["packages", "ROS messages", "first start"]

    def test_another_python_begins_anew(self, ready, launcher, context):
        (ready / ".venv" / "bin" / "python").unlink()
        (ready / ".venv" / "bin" / "python").symlink_to(sys.executable)
        assert self.open_stages(launcher, context)[0] == "Python environment"

    def test_testing_adds_its_own_stages(self, ready, launcher, context, monkeypatch):
        monkeypatch.setattr(launcher, "node_found", lambda: True)
        context = launcher.Context(context.venv, testing=True)
        added = ["torch, for training", "writer of OpenSCENARIO", "test tools"]
        assert self.open_stages(launcher, context) == [*added, "JavaScript readers"]
        monkeypatch.setattr(launcher, "node_found", lambda: False)
        assert self.open_stages(launcher, context) == added

    def test_training_adds_torch_alone(self, ready, launcher, context):
        context = launcher.Context(context.venv, training=True)
        assert self.open_stages(launcher, context) == ["torch, for training"]

    def test_another_torch_is_installed_where_it_is_needed_and_nowhere_else(self, ready, launcher, context):
        training = launcher.Context(context.venv, training=True)
        launcher.stages(training)[-1].mark()
        assert self.open_stages(launcher, training) == []
        with (ready / "config" / "requirements" / "train.txt").open("a") as file:
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
