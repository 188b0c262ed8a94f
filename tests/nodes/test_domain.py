"""Two runs on one machine never hear each other."""

import os
import subprocess
import sys

import pytest

from roadmend.core.errors import InputError, RoadmendError
from roadmend.nodes import domain as domains
from roadmend.nodes.domain import own_domain


@pytest.fixture
def few(monkeypatch):
    """Three domains that nobody else on this machine knows of."""
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    monkeypatch.setattr(domains, "_DOMAINS", range(1, 4))
    monkeypatch.setattr(domains, "_MARK", f"roadmend-test-{os.getpid()}-domain-")


def test_two_runs_never_share_a_domain(few):
    with own_domain() as first, own_domain() as second, own_domain() as third:
        assert len({first, second, third}) == 3


def test_a_run_of_another_process_is_respected_whatever_its_folder_for_temporary_files(monkeypatch, tmp_path):
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    code = (
        "from roadmend.nodes.domain import own_domain\nwith own_domain() as number: print(number, flush=True); input()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", code],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "TMPDIR": str(tmp_path)},
    ) as other:
        taken = int(other.stdout.readline())
        monkeypatch.setattr(domains, "_DOMAINS", range(1, 100))
        monkeypatch.setattr(domains.os, "getpid", lambda: other.pid)  # its first choice is ours
        with own_domain() as mine:
            assert mine != taken
        other.communicate("\n")
    with own_domain() as mine:
        assert mine == taken  # free again


def test_a_domain_is_free_again_after_the_run(few):
    for _ in range(7):
        with own_domain() as number:
            assert number in (1, 2, 3)


def test_when_all_are_taken_the_error_says_what_to_do(few):
    with own_domain(), own_domain(), own_domain():
        with pytest.raises(RoadmendError, match="set ROS_DOMAIN_ID") as caught, own_domain():
            pass
        assert "\n" not in str(caught.value)


def test_a_domain_that_the_user_chose_wins(few, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    with own_domain() as first, own_domain() as second:
        assert first == second == 42


def test_runs_that_must_not_share_a_domain_do_not_take_the_users(few, monkeypatch):
    monkeypatch.setenv("ROS_DOMAIN_ID", "2")
    with own_domain(is_chosen=False) as first, own_domain(is_chosen=False) as second:
        assert {first, second} == {1, 3}
        with pytest.raises(RoadmendError, match=r"end some of them$"), own_domain(is_chosen=False):
            pass


@pytest.mark.parametrize("chosen", ["233", "100000"])
def test_a_domain_that_cannot_be_is_refused(few, monkeypatch, chosen):
    monkeypatch.setenv("ROS_DOMAIN_ID", chosen)
    with pytest.raises(InputError, match=f"ROS_DOMAIN_ID: {chosen} is no DDS domain; choose"), own_domain():
        pass
