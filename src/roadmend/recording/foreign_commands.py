"""Commands of other stacks: read as throttle and brake, and written back with what repair made of them. Needs no ROS."""

import math
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass
from typing import Any, Protocol

from roadmend.core.command import Command
from roadmend.recording import messages
from roadmend.recording.codec import MessageType

ACCELERATION = MessageType("geometry_msgs/msg/AccelStamped")


@dataclass(frozen=True, slots=True)
class Pedals:
    """What a vehicle makes of its pedals."""

    full_throttle: float  # [m/s2] acceleration at throttle 1
    full_brake: float  # [m/s2] deceleration at brake 1


PEDALS = Pedals(3.5, 8.0)  # of a mid-size car, where nobody says otherwise


class CommandForm(Protocol):
    """How one type of message says what a throttle and a brake say."""

    type_name: str  # package/msg/Name; its first field is a header

    def decode(self, data: bytes) -> Any:
        """A message of this type.

        Raises:
            ValueError: the bytes are none.
        """

    def read(self, message: Any) -> Command:
        """The command; not checked, see Command.fault."""

    def write(self, command: Command, header: Any, asked: Any | None) -> Any:
        """The message for the vehicle.

        Args:
            command: what the vehicle shall do; a valid one.
            header: of a message that was not asked for.
            asked: the message that was asked for, from which everything is taken that repair says nothing about, such
                as steering; None where there was none.
        """


class PedalForm:
    """roadmend_msgs/Command."""

    type_name = messages.COMMAND.name

    def __init__(self, pedals: Pedals) -> None:
        del pedals  # it names them itself

    def decode(self, data: bytes) -> Any:
        """A message."""
        return messages.COMMAND.decode(data)

    def read(self, message: Any) -> Command:
        """As it is."""
        return messages.command_of(message)

    def write(self, command: Command, header: Any, asked: Any | None) -> Any:
        """As it is."""
        del asked
        return messages.command_message_of(command, header)


class AccelerationForm:
    """geometry_msgs/AccelStamped: accel.linear.x is the longitudinal acceleration [m/s2], negative to brake.

    What is beyond the vehicle's full throttle or brake means these; a value that is not finite is no command. All else
    in the message, the lateral and the angular acceleration, passes through; without a command to repair it is zero.
    """

    type_name = ACCELERATION.name

    def __init__(self, pedals: Pedals) -> None:
        self._pedals = pedals

    def decode(self, data: bytes) -> Any:
        """A message."""
        return ACCELERATION.decode(data)

    def read(self, message: Any) -> Command:
        """Throttle or brake in the share of the vehicle's full ones."""
        wanted = message.accel.linear.x
        if not math.isfinite(wanted):  # no command; but of two ways to brake the harder one where that was asked for
            return Command(0.0, math.inf) if wanted < 0.0 else Command(math.nan, 0.0)
        if wanted < 0.0:
            return Command(0.0, min(1.0, -wanted / self._pedals.full_brake))
        return Command(min(1.0, wanted / self._pedals.full_throttle), 0.0)

    def write(self, command: Command, header: Any, asked: Any | None) -> Any:
        """The acceleration that the pedals stand for; exactly the one that was asked for where they are the same."""
        if asked is not None and self.read(asked) == command:
            return asked
        message = copy(ACCELERATION() if asked is None else asked)
        message.accel = copy(message.accel)
        message.accel.linear = copy(message.accel.linear)
        pedals = self._pedals
        message.accel.linear.x = command.throttle * pedals.full_throttle - command.brake * pedals.full_brake
        if asked is None:
            message.header = header
        return message


COMMAND_FORMS: dict[str, Callable[[Pedals], CommandForm]] = {
    PedalForm.type_name: PedalForm,
    AccelerationForm.type_name: AccelerationForm,
}
