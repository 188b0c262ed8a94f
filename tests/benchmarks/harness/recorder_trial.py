"""Trials of the recorder under load, as real processes: what it takes in, and what is left when it is killed."""

import contextlib
import json
import random
import select
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from harness.load import BEGUN, DATA, MARK
from harness.processes import node_environment
from roadmend.core.errors import RoadmendError
from roadmend.nodes.domain import own_domain
from roadmend.recording.reader import BagReader
from roadmend.recording.recovery import recover

_SECOND = 1e9


@dataclass(frozen=True, slots=True)
class Load:
    """What the recorder has to take in."""

    count: int
    rate: float = 0.0  # messages a second; 0: as many as are taken
    size: int = 20_000  # [bytes] of data in each


@dataclass(frozen=True, slots=True)
class Recorded:
    """What came of recording a load to its end."""

    published: int
    recorded: int
    offered_rate: float  # messages a second, as they were published
    seconds: float  # between the first and the last message that the recorder wrote
    disk_bytes: int

    @property
    def dropped(self) -> int:
        """Messages that are not in the bag."""
        return self.published - self.recorded

    @property
    def megabytes_per_second(self) -> float:
        """To the disk."""
        return self.disk_bytes / 1e6 / self.seconds


@dataclass(frozen=True, slots=True)
class Killed:
    """What was left of a recording that SIGKILL ended."""

    recovered: int
    holes: int  # messages missing before the last one that is left
    lost_seconds: float  # from the publishing of the last message that is left to the kill


def record(folder: Path, load: Load, compression: str = "zstd") -> Recorded:
    """Record a load to its end.

    Raises:
        RoadmendError: a process did not do its part.
    """
    with _processes(folder, load, compression) as (recorder, publisher):
        printed, _ = publisher.communicate(timeout=600)
        if publisher.returncode or not printed:
            raise RoadmendError(f"the load was not published (exit code {publisher.returncode})")
        told = json.loads(printed.splitlines()[-1])
        recorder.terminate()
        if recorder.wait(timeout=120):
            raise RoadmendError(f"the recorder failed (exit code {recorder.returncode})")
    bag = BagReader(folder / "bag")
    times = [one.time_ns for one in bag.records(["/load"])]
    size = sum(file.stat().st_size for file in (folder / "bag").glob("*.mcap"))
    seconds = (times[-1] - times[0]) / _SECOND if times else 0.0
    return Recorded(told["published"], len(times), told["published"] / told["seconds"], seconds, size)


def kill(folder: Path, load: Load, after: float) -> Killed:
    """Kill the recorder ``after`` seconds of the load, and recover what is left.

    Raises:
        RoadmendError: a process did not do its part.
        InputError: nothing could be recovered.
    """
    with _processes(folder, load, "zstd") as (recorder, _publisher):
        time.sleep(after)
        killed = time.time_ns()
        recorder.kill()
        recorder.wait()
    recover(folder / "bag", folder / "recovered")
    marks = [MARK.unpack_from(one.data, DATA) for one in BagReader(folder / "recovered").records(["/load"])]
    if not marks:
        return Killed(0, 0, after)
    last, published = max(marks)
    return Killed(len(marks), last + 1 - len({number for number, _ in marks}), (killed - published) / _SECOND)


def moments(count: int, seed: int = 7) -> list[float]:
    """Random moments [s] at which to kill."""
    draw = random.Random(seed)
    return [draw.uniform(0.5, 3.0) for _ in range(count)]


@contextlib.contextmanager
def _processes(
    folder: Path, load: Load, compression: str
) -> Iterator[tuple[subprocess.Popen[bytes], subprocess.Popen[bytes]]]:
    """A recorder and a publisher that has begun; gone at the end."""
    with own_domain() as domain:
        environment = node_environment(domain)
        recorder = _start(
            environment,
            "roadmend.nodes.recorder",
            output=folder,
            name="bag",
            include="^/load$",
            time_source="system",
            compression=compression,
            drain_limit=60.0,
        )
        publisher = _start(environment, "harness.load", count=load.count, rate=float(load.rate), bytes=load.size)
        try:
            _await_begin(recorder, publisher)
            yield recorder, publisher
        finally:
            for process in (recorder, publisher):
                process.kill()
                process.wait()
                if process.stdout is not None:
                    process.stdout.close()


def _await_begin(recorder: subprocess.Popen[bytes], publisher: subprocess.Popen[bytes]) -> None:
    """Until the publisher says that it has begun; what Fast DDS prints before that is passed over."""
    assert publisher.stdout is not None
    printed = []
    while recorder.poll() is None:
        if select.select([publisher.stdout], [], [], 0.2)[0]:
            line = publisher.stdout.readline().decode()
            if line == f"{BEGUN}\n":
                return
            if not line:
                break
            printed.append(line)
    codes = f"exit codes {recorder.poll()}, {publisher.poll()}"
    raise RoadmendError(f"nobody records the load ({codes}); the publisher printed: {''.join(printed) or 'nothing'}")


def _start(environment: dict[str, str], module: str, **parameters: object) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", module, "--ros-args"]
    for name, value in parameters.items():
        command += ["-p", f"{name}:={value}"]
    # Without a buffer, a line that is not read yet is one that select sees.
    return subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, bufsize=0)
