"""Declare ROS parameters with a description, a range and a reason when a value is refused."""

from collections.abc import Sequence
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node

from roadmend.core.errors import InputError


def declare(
    node: Node,
    name: str,
    default: Any,
    description: str,
    *,
    low: float | None = None,
    high: float | None = None,
    choices: Sequence[str] = (),
    read_only: bool = True,
) -> Any:
    """Declare one parameter and return its value.

    Args:
        node: the node that owns it.
        name: its name.
        default: used where neither the command line nor a file gives a value; also fixes the type.
        description: one line for people.
        low: smallest value allowed.
        high: largest value allowed.
        choices: the texts allowed; all if empty.
        read_only: whether it keeps the value it had at the start.

    Raises:
        InputError: the value given is of another type, outside the range or not among the choices.
    """
    descriptor = ParameterDescriptor(description=description, read_only=read_only)
    if choices:
        descriptor.additional_constraints = "one of " + ", ".join(choices)
    if low is not None or high is not None:
        _set_range(descriptor, default, low, high)
    try:
        value = node.declare_parameter(name, default, descriptor).value
    except (InvalidParameterValueException, InvalidParameterTypeException) as error:
        given = " ".join(str(error).split()).removesuffix(f": {name}")
        raise InputError(f"parameter {name}", given, f"it is: {description}") from None
    if choices and value not in choices:
        raise InputError(f"parameter {name}", f"{value!r} is not allowed", f"choose one of {', '.join(choices)}")
    return value


def _set_range(descriptor: ParameterDescriptor, default: Any, low: float | None, high: float | None) -> None:
    if isinstance(default, int) and not isinstance(default, bool):
        descriptor.integer_range = [
            IntegerRange(
                from_value=-(2**62) if low is None else int(low), to_value=2**62 if high is None else int(high), step=0
            )
        ]
    else:
        descriptor.floating_point_range = [
            FloatingPointRange(
                from_value=-1e300 if low is None else float(low),
                to_value=1e300 if high is None else float(high),
                step=0.0,
            )
        ]
