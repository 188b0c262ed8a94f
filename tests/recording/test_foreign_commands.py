import math

import pytest

from roadmend.core.command import Command
from roadmend.recording.codec import encode
from roadmend.recording.foreign_commands import COMMAND_FORMS, AccelerationForm, PedalForm, Pedals
from roadmend.recording.messages import command_message_of
from roadmend.repair.sanitise import sanitise_command

from .foreign_messages import acceleration, header

PEDALS = Pedals(full_throttle=4.0, full_brake=8.0)


@pytest.mark.parametrize(
    ("wanted", "command"),
    [
        (0.0, Command(0.0, 0.0)),
        (1.0, Command(0.25, 0.0)),
        (4.0, Command(1.0, 0.0)),
        (9.0, Command(1.0, 0.0)),
        (-2.0, Command(0.0, 0.25)),
        (-8.0, Command(0.0, 1.0)),
        (-50.0, Command(0.0, 1.0)),
    ],
)
def test_an_acceleration_as_pedals(wanted, command):
    assert AccelerationForm(PEDALS).read(acceleration(0.0, wanted)) == command


@pytest.mark.parametrize(("wanted", "brake"), [(math.nan, 0.5), (math.inf, 0.5), (-math.inf, 1.0)])
def test_what_is_not_finite_brakes(wanted, brake):
    form, asked = AccelerationForm(PEDALS), acceleration(0.0, wanted)
    command = form.read(asked)
    assert command.fault
    assert sanitise_command(command, 0.5) == Command(0.0, brake)
    assert form.write(Command(0.0, brake), header(7.0), asked).accel.linear.x == -8.0 * brake


def test_an_unchanged_command_passes_as_the_very_message():
    asked = acceleration(3.0, 9.0, 0.4, 0.1)
    form = AccelerationForm(PEDALS)
    assert form.write(form.read(asked), header(7.0), asked) is asked


def test_a_repaired_one_keeps_all_but_the_longitudinal_acceleration():
    asked = acceleration(3.0, 2.0, 0.4, 0.1)
    told = AccelerationForm(PEDALS).write(Command(0.0, 0.5), header(7.0), asked)
    assert (told.accel.linear.x, told.accel.linear.y, told.accel.angular.z) == (-4.0, 0.4, 0.1)
    assert told.header is asked.header
    assert asked.accel.linear.x == 2.0  # messages are values


def test_without_a_command_the_stop_has_the_given_header():
    told = AccelerationForm(PEDALS).write(Command(0.0, 1.0), header(7.0), None)
    assert (told.accel.linear.x, told.accel.linear.y, told.header.stamp.sec) == (-8.0, 0.0, 7)
    again = AccelerationForm(PEDALS).write(Command(0.0, 0.5), header(8.0), None)
    assert (told.accel.linear.x, again.accel.linear.x) == (-8.0, -4.0)


def test_pedals_are_what_they_are():
    form = PedalForm(PEDALS)
    asked = command_message_of(Command(0.3, 0.0, True), header(1.0))
    assert form.read(asked) == Command(0.3, 0.0, True)
    told = form.write(Command(0.0, 0.5), header(7.0), asked)
    assert (told.throttle, told.brake, told.header.stamp.sec) == (0.0, 0.5, 7)


@pytest.mark.parametrize("name", COMMAND_FORMS)
def test_what_is_written_is_read_by_the_form_itself(name):
    form = COMMAND_FORMS[name](PEDALS)
    for command in (Command(0.25, 0.0), Command(0.0, 0.75), Command(0.0, 0.0)):
        assert form.read(form.decode(encode(form.write(command, header(1.0), None)))) == command
