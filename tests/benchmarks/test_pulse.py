import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from harness.pulse import DoseExceededError, Pulse, PulsePlayer
from roadmend.core.command import Command, Decision, Trajectory
from roadmend.core.scene import EgoState, ObjectList, Scene
from roadmend.repair.actions import ACTIONS

SCENE = Scene(
    0.0, EgoState.from_yaw(0.0, 0.0, 0.0, 5.0, 0.0, 4.5, 1.8), ObjectList.empty(), np.zeros(0, dtype=np.uint8)
)
actions = st.floats(-1.0, 1.0)
pulses = st.builds(Pulse, st.integers(0, 20), st.integers(1, 20), st.sampled_from(ACTIONS))


def play(player, asked):
    player.reset(None)
    return [player.step(SCENE, Decision(Command.from_action(action), Trajectory.empty())) for action in asked]


@given(st.lists(pulses, max_size=3), st.lists(actions, max_size=40))
def test_the_lesser_of_policy_and_pulse_is_driven(planned, asked):
    repairs = play(PulsePlayer(planned), asked)
    for tick, (action, repair) in enumerate(zip(asked, repairs, strict=True)):
        within = [pulse.action for pulse in planned if pulse.start <= 0.05 * tick + 1e-9 < pulse.start + pulse.duration]
        assert repair.final_action == pytest.approx(min([action, *within]))
        assert repair.intervened == (repair.final_action < repair.policy_action)


def test_it_stops_where_the_dose_reaches_the_limit():
    asked = [0.5] * 10
    play(PulsePlayer((Pulse(2, 4, -1.0),), limit=0.31), asked)  # 4 * 1.5 * 0.05 s
    with pytest.raises(DoseExceededError):
        play(PulsePlayer((Pulse(2, 4, -1.0),), limit=0.30), asked)


def test_the_policys_wishes_are_kept_for_one_episode():
    player = PulsePlayer((Pulse(0, 5, -1.0),))
    play(player, [0.5, 0.25])
    play(player, [0.125])
    assert player.actions == [0.125]
