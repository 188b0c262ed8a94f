"""A policy of one's own drives as ours do; one that fails is said in one line."""

import numpy as np
import pytest

from roadmend.core.errors import ForeignError, InputError
from roadmend.core.plain_moment import plain_moment
from roadmend.core.repair import RepairStatus
from roadmend.policies.registry import make_policy
from roadmend.repair.registry import make_repairer
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode
from tests.core.own_code import POLICY

SCENARIO = sample_scenario("S3", 0).model_copy(update={"time_limit": 3.0})


def drive(given):
    return run_episode(SCENARIO, make_policy(given), make_repairer("none"))


def test_it_drives_under_the_name_that_it_was_asked_for_by(own):
    given = f"{own(POLICY)}:Careful"
    assert drive(given).policy == given
    assert drive(given).digest == drive(given).digest


def test_one_that_fails_on_the_way_is_said_with_time_and_place(own, tmp_path):
    name = own(POLICY)
    with pytest.raises(ForeignError) as caught:
        drive(f"{name}:Late")
    place = tmp_path / "theirs" / f"{name}.py"
    assert str(caught.value) == (
        f"policy {name}:Late: failed in step at 1.05 s: ZeroDivisionError: division by zero ({place} line 15); "
        "mend the class"
    )


@pytest.mark.parametrize(
    ("answer", "said"),
    [
        ("return None", "its step at 0.00 s answered with NoneType; answer with a roadmend.core.command.Decision"),
        ("return Decision(0.5, Trajectory.empty())", "answered with float; answer with a Decision with a Command"),
        ("return Decision(Command(0.0, 0.0), None)", "answered with NoneType; answer with a Decision with a Traj"),
        (
            "return Decision(Command('0.3', 0.0), Trajectory.empty())",
            "with str; answer with a Command whose throttle is",
        ),
        (
            "return Decision(Command(0.0, None), Trajectory.empty())",
            "NoneType; answer with a Command whose brake is a num",
        ),
        (
            "return Decision(Command(0.3 + 0j, 0.0), Trajectory.empty())",
            "with complex; answer with a Command whose thro",
        ),
        (
            "return Decision(Command([0.3, 0.3], 0.0), Trajectory.empty())",
            "with list; answer with a Command whose thro",
        ),
        (
            "return Decision(Command([[0.3]], 0.0), Trajectory.empty())",
            "with list; answer with a Command whose throttle",
        ),
        (
            "return Decision(Command(0.0, 0.0, 'no'), Trajectory.empty())",
            "a Command whose change_lane is True or False",
        ),
        (
            "return Decision(Command(0.0, 0.0), Trajectory(0.5, [1.0], ['far'], [0.0], [1.0]))",
            "answered with list; answer with a Trajectory whose y is a row of numbers",
        ),
        (
            "return Decision(Command(0.0, 0.0), Trajectory(0.5, 1.0, [2.0], [0.0], [1.0]))",
            "answered with float; answer with a Trajectory whose x is a row of numbers",
        ),
        (
            "return Decision(Command(0.0, 0.0), Trajectory(None, [1.0], [2.0], [0.0], [1.0]))",
            "answered with NoneType; answer with a Trajectory whose interval is a number",
        ),
        (
            "return Decision(Command(0.0, 0.0), Trajectory(0.5, [1.0], [2.0], [0.0], [1.0], None))",
            "answered with NoneType; answer with a Trajectory whose behaviour is a text",
        ),
        (
            "return Decision(Command(0.0, 0.0), Trajectory(0.5, [1.0], [2.0], [0.0], [1.0], chr(0xD800)))",
            "answered with str; answer with a Trajectory whose behaviour is a text",
        ),
        ("return scene.nothing", "failed in step at 0.00 s: AttributeError"),
    ],
)
def test_one_that_cannot_answer_a_plain_scene_is_refused_before_it_drives(own, answer, said):
    name = own(POLICY + f"\nclass Wrong(Careful):\n    def step(self, scene):\n        {answer}\n")
    with pytest.raises(InputError) as caught:
        make_policy(f"{name}:Wrong")
    assert "cannot answer a plain scene: " in str(caught.value)
    assert said in str(caught.value)


@pytest.mark.parametrize("speeds", ["[1, 1]", "__import__('numpy').ones(2, dtype='float32')"])
def test_a_plan_of_lists_or_other_numbers_is_a_plan(own, speeds):
    plan = f"Trajectory(0.5, [scene.ego.x + 1, scene.ego.x + 2], [scene.ego.y] * 2, [scene.ego.yaw] * 2, {speeds})"
    name = own(
        POLICY + f"\nclass Lists(Careful):\n    def step(self, scene):\n"
        f"        return Decision(Command(0.1, 0.0), {plan})\n"
    )
    policy, seen = make_policy(f"{name}:Lists"), []
    run_episode(SCENARIO, policy, make_repairer("rss"), lambda tick, decision, repair: seen.append((decision, repair)))
    assert len(seen) == 60
    assert all(decision.trajectory.speed.dtype == np.float64 for decision, _ in seen)
    assert not any(repair.status is RepairStatus.MODEL_FAULT or "trajectory" in repair.reason for _, repair in seen)


def test_an_interval_of_one_number_is_a_number_however_it_is_written(own):
    plan = "Trajectory(__import__('numpy').array([0.5]), [scene.ego.x], [scene.ego.y], [scene.ego.yaw], [0.0])"
    step = f"return Decision(Command(0.1, 0.0), {plan})"
    name = own(POLICY + f"\nclass Plan(Careful):\n    def step(self, scene):\n        {step}\n")
    policy, moment = make_policy(f"{name}:Plan"), plain_moment()
    policy.reset(moment.route)
    assert type(policy.step(moment.scene).trajectory.interval) is float


@pytest.mark.parametrize("pedal", ["array(0.25)", "array([0.25])", "float32(0.25)", "float16([0.25])"])
def test_a_pedal_of_one_number_is_a_number_however_it_is_written(own, pedal):
    drives = []
    for throttle in (f"__import__('numpy').{pedal}", "0.25"):
        step = f"return Decision(Command({throttle}, 0.0, scene.time > 1.0), Trajectory.empty())"
        name = own(POLICY + f"\nclass Pedal(Careful):\n    def step(self, scene):\n        {step}\n")
        drives.append(drive(f"{name}:Pedal"))
    assert drives[0].digest == drives[1].digest
    assert drives[0].distance > 5.0


def test_a_pedal_that_is_no_number_on_the_way_ends_the_drive(own):
    step = "return Decision(Command('0.3' if scene.time > 1.0 else 0.3, 0.0), Trajectory.empty())"
    name = own(POLICY + f"\nclass Later(Careful):\n    def step(self, scene):\n        {step}\n")
    with pytest.raises(
        ForeignError, match=r"its step at 1\.05 s answered with str; answer with a Command whose throttle"
    ):
        drive(f"{name}:Later")


def test_its_parameters_are_checked_as_ours_are(own):
    text = """
from pydantic import Field
from roadmend.core.parameters import Parameters

class Settings(Parameters):
    pace: float = Field(8.0, ge=0.0, le=20.0, description="speed that is kept [m/s]")

class Paced(Careful):
    def __init__(self, parameters: Settings):
        self.pace = parameters.pace
"""
    given = f"{own(POLICY + text)}:Paced"
    assert make_policy(given).policy.pace == 8.0
    assert make_policy(given, {"pace": 9.0}).policy.pace == 9.0
    with pytest.raises(InputError, match=r"policy\.Paced\.pace: .*; speed that is kept"):
        make_policy(given, {"pace": 21.0})
    with pytest.raises(InputError, match=r"is unknown, did you mean pace\?"):
        make_policy(given, {"pase": 2.0})
