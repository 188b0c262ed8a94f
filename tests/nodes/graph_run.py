"""``roadmend run`` in a process of its own, what it sends and records, and hands to stop its nodes."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from roadmend_msgs.msg import Command

from roadmend.nodes.heartbeat import SETTLED_BEATS, Pulse
from roadmend.recording.reader import BagReader

ENOUGH = 10  # ticks after which something counts as going on


def children_of(number):
    text = Path(f"/proc/{number}/task/{number}/children").read_text()
    return [each for child in text.split() for each in (int(child), *children_of(int(child)))]


class Run:
    """Records into ``bags``/bag; what is waited for may take minutes, as it does beside much else."""

    def __init__(self, scenario, bags, *more):
        command = [sys.executable, "-m", "roadmend.cli", "run", "--scenario", str(scenario), "--out", str(bags)]
        command += ["--name", "bag", "--no-viz", "--json", *more]
        self.bag = bags / "bag"
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.lines = []
        self._reader = threading.Thread(target=lambda: self.lines.extend(self.process.stderr), daemon=True)
        self._reader.start()

    def node(self, name):
        """The process of a node that is there or comes up."""
        for _ in range(1200):
            for number, called in self.nodes().items():
                if called == name:
                    return number
            time.sleep(0.05)
        pytest.fail(f"no {name}: {self.lines}")

    def nodes(self):
        """The processes of the nodes that are there, and their names."""
        named = {}
        for number in children_of(self.process.pid):
            with contextlib.suppress(OSError):  # it has gone meanwhile
                named[number] = Path(f"/proc/{number}/comm").read_text().strip()
        return {number: name for number, name in named.items() if name.endswith("_node")}

    def until_driving(self, *, settled=True):
        """Until the policy has decided for some ticks; ``settled``: and every node came round so often that it is up."""
        self.until_seen("/policy/command", Command)
        pulses = [Pulse(log.with_suffix(".beat")) for log in map(log_of, self.nodes())] if settled else []
        for _ in range(2400):
            for pulse in pulses:
                pulse.look(time.monotonic())
            assert self.process.poll() is None, self.lines
            if all(pulse.beats > SETTLED_BEATS for pulse in pulses):  # and as often for the launcher, who began before
                return
            time.sleep(0.02)
        pytest.fail(f"somebody does not come round: {pulses} {self.lines}")

    def until_seen(self, topic, kind, wanted=lambda _: True, *, ticks=ENOUGH, profile=10):
        """Until messages that are wanted were sent for more than so many ticks, from now on if they are not latched."""
        context, stamps = Context(), set()
        rclpy.init(context=context)
        node = Node("onlooker", context=context)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(node)
        node.create_subscription(
            kind, topic, lambda message: wanted(message) and stamps.add(stamp_of(message)), profile
        )
        try:
            for _ in range(2400):
                executor.spin_once(timeout_sec=0.05)
                if len(stamps) > ticks:
                    return
                assert self.process.poll() is None, self.lines
        finally:
            executor.shutdown()
            node.destroy_node()
            context.try_shutdown()
        pytest.fail(f"too little on {topic}: {self.lines}")

    def until_said(self, *words):
        """Until a line with all of the words was said; the last such line."""
        for _ in range(2400):
            found = [line for line in [*self.lines] if all(word in line for word in words)]
            if found:
                return found[-1]
            assert self.process.poll() is None, self.lines
            time.sleep(0.05)
        pytest.fail(f"no line with {words}: {self.lines}")

    def interrupt(self):
        """As Ctrl-C does; exit code and what was said."""
        self.process.send_signal(signal.SIGINT)
        code, _, said = self.end()
        return code, said

    def close(self):
        """End it, however it is."""
        if self.process.poll() is None:
            for number in children_of(self.process.pid):
                os.kill(number, signal.SIGCONT)
        self.process.terminate()
        self.process.wait(timeout=100)

    def end(self):
        """Exit code, result (None if it has none) and what was said."""
        printed = self.process.stdout.read()
        code = self.process.wait(timeout=200)
        self._reader.join(timeout=20)
        return code, json.loads(printed)[0] if printed.strip() else None, "".join(self.lines)


def log_of(number):
    """Where a node says what it says."""
    return Path(f"/proc/{number}/fd/1").readlink()


def records(bag, *topics):
    return [message.value for message in BagReader(bag).messages(topics)]


def stamp_of(message):
    return message.header.stamp.sec * 10**9 + message.header.stamp.nanosec
