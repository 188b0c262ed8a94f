import os

import pytest

from roadmend.core.branch import branch
from roadmend.core.errors import InputError, SimulationError


def test_a_copy_answers_and_leaves_no_trace():
    kept = [1]

    def work():
        kept.append(2)
        return os.getpid(), kept

    child, seen = branch(work)
    assert child != os.getpid()
    assert seen == [1, 2]
    assert kept == [1]
    with pytest.raises(ChildProcessError):
        os.waitpid(child, os.WNOHANG)  # nothing is left of it


def test_an_error_of_ours_comes_out_as_it_went_in_and_another_in_one_line():
    def refuse():
        raise InputError("s.yaml", "has no lanes", "add one")

    with pytest.raises(InputError, match="has no lanes"):
        branch(refuse)
    with pytest.raises(SimulationError, match="KeyError: 'here'"):
        branch(lambda: {}["here"])


def test_a_copy_that_dies_is_an_error():
    with pytest.raises(SimulationError, match="died"):
        branch(lambda: os._exit(3))


def test_an_answer_that_cannot_travel_is_an_error():
    with pytest.raises(SimulationError, match=r"died|pickle"):
        branch(lambda: lambda: 1)
