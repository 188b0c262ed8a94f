"""A repair method of one's own is behind the guard, as all are."""

import pytest

from roadmend.core.errors import InputError
from roadmend.core.repair import RepairStatus
from roadmend.repair.registry import make_method, make_repairer
from tests.core.own_code import METHOD

from .playground import Box, keep_on, scene_of, straight_route


def answers(given, *times, **parameters):
    repairer = make_repairer(given, parameters)
    repairer.reset(straight_route())
    scenes = [scene_of([Box(1, 6.0, 0.0, speed=5.0)], time) for time in times]
    return repairer, [repairer.step(scene, keep_on(scene)) for scene in scenes]


def test_it_repairs_under_the_name_that_it_was_asked_for_by(own):
    given = f"{own(METHOD)}:Near"
    repairer, (_, repair) = answers(given, 0.0, 0.05)
    assert repairer.name == given
    assert (repair.status, repair.command.brake) == (RepairStatus.REPAIRED, 0.8)
    _, (_, repair) = answers(given, 0.0, 0.05, distance=1.0)
    assert repair.status is RepairStatus.PASS
    assert repairer.first_fault == ""


def test_it_gets_the_seed(own):
    assert make_method(f"{own(METHOD)}:Near", seed=7).method.seed == 7


def test_where_it_fails_the_guards_rule_decides_and_says_why(own):
    name = own(METHOD)
    repairer, (before, after) = answers(f"{name}:Late", 0.95, 1.05)
    assert before.status is not RepairStatus.MODEL_FAULT
    assert after.status is RepairStatus.MODEL_FAULT
    assert f"{name}:Late failed: " in after.reason
    assert "KeyError: 'lost'" in after.reason
    assert f"{name}.py line 22" in after.reason
    assert repairer.first_fault in after.reason


@pytest.mark.parametrize("action", ["array(-0.5)", "array([-0.5])", "float32(-0.5)"])
def test_an_answer_of_one_number_is_a_number_however_it_is_written(own, action):
    given = f"Proposal(numpy.array([2.0]), numpy.float32(1.0), numpy.{action})"
    step = f"import numpy\n        return {given}"
    name = own(METHOD + f"\nclass Model(Near):\n    def propose(self, scene, decision):\n        {step}\n")
    _, (_, repair) = answers(f"{name}:Model", 0.0, 0.05)
    assert (repair.status, repair.command.brake) == (RepairStatus.REPAIRED, 0.5)
    assert [type(value) for value in (repair.score, repair.threshold, repair.repair_action)] == [float] * 3


@pytest.mark.parametrize("given", ["[0.0, 0.0], 1.0, -0.8", "0.0, None, -0.8", "0.0, 1.0, 'full'"])
def test_an_answer_that_is_no_number_is_the_methods_fault(own, given):
    step = f"return Proposal({given}) if scene.time > 1.0 else super().propose(scene, decision)"
    name = own(METHOD + f"\nclass Wrong(Near):\n    def propose(self, scene, decision):\n        {step}\n")
    _, (_, repair) = answers(f"{name}:Wrong", 0.95, 1.05)
    assert repair.status is RepairStatus.MODEL_FAULT
    assert f"{name}:Wrong failed: " in repair.reason
    assert "answered with a Proposal whose " in repair.reason


def test_one_that_never_answers_is_refused(own):
    with pytest.raises(InputError, match=r"cannot answer a plain scene: answered with float; answer with a roadmend"):
        make_repairer(f"{own(METHOD)}:Never")


def test_its_parameters_are_checked_as_ours_are(own):
    with pytest.raises(InputError, match=r"Near\.distance: "):
        make_repairer(f"{own(METHOD)}:Near", {"distance": -1.0})


def test_a_model_file_is_the_method_that_it_is_for():
    from roadmend.networks.checkpoint import find_model

    path = str(find_model("neural", "adreft-"))
    assert make_method(path).model.digest == make_method("adreft", {"model": "neural"}).model.digest
    assert make_repairer(str(find_model("modular", "self_oracle-"))).name == "model"
    with pytest.raises(InputError, match="of the kind 'neural', which does not repair"):
        make_repairer(str(find_model("neural")))
