"""A graph on one machine listens to that machine alone, unless it is told otherwise."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from roadmend.nodes.loopback import HERE, PROFILE, RANGE, reach

LISTEN = """
import os, rclpy
from rclpy.node import Node
rclpy.init(domain_id=%d)
node = Node("listener")
held = set()
for number in os.listdir("/proc/self/fd"):
    try:
        held.add(os.readlink(f"/proc/self/fd/{number}"))
    except OSError:
        pass
for line in open("/proc/self/net/udp").read().splitlines()[1:]:
    words = line.split()
    if f"socket:[{words[9]}]" in held:
        address, port = words[1].split(":")
        print(address, int(port, 16))
rclpy.shutdown()
"""


@pytest.fixture
def bare(monkeypatch):
    monkeypatch.delenv(RANGE, raising=False)
    monkeypatch.delenv(PROFILE, raising=False)


def test_unless_told_otherwise_nodes_stay_on_this_machine(bare, monkeypatch):
    found = reach()
    assert found[RANGE] == HERE
    assert Path(found[PROFILE]).is_file()
    assert reach("SUBNET") == {RANGE: "SUBNET"}
    monkeypatch.setenv(RANGE, "SUBNET")
    assert reach() == {RANGE: "SUBNET"}
    monkeypatch.setenv(RANGE, "")
    monkeypatch.setenv(PROFILE, "mine.xml")
    assert reach() == {RANGE: HERE}  # what the user says of Fast DDS wins


@pytest.mark.parametrize("is_open", [False, True])
def test_the_ports_at_which_a_node_is_found_are_on_loopback(bare, domain, is_open):
    """Fast DDS sends from further sockets, at ports that the system gives; nothing is read from them."""
    environment = os.environ | ({RANGE: "SUBNET"} if is_open else reach())
    printed = subprocess.run(
        [sys.executable, "-c", LISTEN % domain],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
        timeout=100,
    ).stdout
    begin = 7400 + 250 * domain
    found = [line.split()[0] for line in printed.splitlines() if begin <= int(line.split()[1]) < begin + 250]
    assert found
    assert (set(found) == {"0100007F"}) is not is_open, printed
