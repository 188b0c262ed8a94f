"""Declare ROS parameters with a description, a range and a reason when a value is refused."""

from collections.abc import Mapping, Sequence
from enum import Enum
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo
from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterTypeException, InvalidParameterValueException
from rclpy.node import Node

from roadmend.core.errors import InputError
from roadmend.core.parameters import AnyParameters, Parameters, bound_of, with_defaults
from roadmend.core.registry import Entry, Found, Registry


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
    value = _declared(node, name, default, descriptor)
    if choices and value not in choices:
        raise InputError(f"parameter {name}", f"{value!r} is not allowed", f"choose one of {', '.join(choices)}")
    return value


def declare_name(node: Node, name: str, default: str, description: str, registry: Registry[Any]) -> str:
    """Declare a parameter that names something of a registry, and return it as it was given.

    Raises:
        InputError: it names nothing, or something that cannot be used.
    """
    descriptor = ParameterDescriptor(description=description, read_only=True)
    descriptor.additional_constraints = f"one of {registry.ways}"
    value = str(_declared(node, name, default, descriptor))
    find_named(name, value, registry)
    return value


def find_named(name: str, value: str, registry: Registry[Entry]) -> Found[Entry]:
    """What the value of a parameter names.

    Raises:
        InputError: it names nothing, or something that cannot be used.
    """
    try:
        return registry.find(value)
    except InputError as error:
        where = f"parameter {name}" if error.where == registry.noun else f"parameter {name}: {error.where}"
        raise InputError(where, error.what, error.mend) from None


def _declared(node: Node, name: str, default: Any, descriptor: ParameterDescriptor) -> Any:
    try:
        return node.declare_parameter(name, default, descriptor).value
    except (InvalidParameterValueException, InvalidParameterTypeException) as error:
        given = " ".join(str(error).split()).removesuffix(f": {name}")
        raise InputError(f"parameter {name}", given, f"it is: {descriptor.description}") from None


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


def declare_parameters(
    node: Node, model: type[AnyParameters], *, choices: Mapping[str, Sequence[str]] | None = None, is_fixed: bool = True
) -> AnyParameters:
    """Declare every field of a parameter model and return the values as such a model.

    Descriptions and bounds (``ge``, ``le``) are the fields', and a Literal's values are the choices.

    Args:
        node: the node that owns them.
        model: names, defaults, ranges and meanings.
        choices: the texts allowed in fields whose type does not say it.
        is_fixed: whether the parameters keep the values they had at the start.

    Raises:
        InputError: a value is of another type, outside its range or not among the choices.
    """
    values = {
        name: declare_field(node, name, info, (choices or {}).get(name, ()), is_fixed=is_fixed)
        for name, info in model.model_fields.items()
    }
    return model.model_validate(values)


def declare_own(
    node: Node,
    prefix: str,
    model: type[Parameters],
    defaults: Mapping[str, Any] | None = None,
    *,
    is_fixed: bool = True,
) -> list[str]:
    """Declare the plain fields of a parameter model under a prefix, as in "rss.rho", and return the fields' names.

    Args:
        node: the node that owns them.
        prefix: what stands before the dot.
        model: names, defaults, ranges and meanings; a field that holds more than one plain value cannot be set by ROS.
        defaults: that hold instead of the model's.
        is_fixed: whether the parameters keep the values they had at the start.

    Raises:
        InputError: a value is of another type, outside its range or not among the choices.
    """
    names = []
    for name, info in with_defaults(model, **(defaults or {})).model_fields.items():
        default = info.get_default(call_default_factory=True)
        if isinstance(default, bool | int | float | str) and not isinstance(default, Enum):
            declare_field(node, f"{prefix}.{name}", info, is_fixed=is_fixed)
            names.append(name)
    return names


def declare_field(node: Node, name: str, info: FieldInfo, choices: Sequence[str] = (), *, is_fixed: bool = True) -> Any:
    """Declare one field of a parameter model under ``name`` and return its value; see :func:`declare_parameters`.

    Raises:
        InputError: the value is of another type, outside its range or not among the choices.
    """
    default = info.get_default(call_default_factory=True)
    is_list = isinstance(default, tuple)
    is_number = isinstance(default, int | float) and not isinstance(default, bool)
    value = declare(
        node,
        name,
        (list(default) or [""]) if is_list else default,  # ROS takes an empty list for one of no type
        info.description or name,
        low=bound_of(info, "ge") if is_number else None,
        high=bound_of(info, "le") if is_number else None,
        choices=choices or (get_args(info.annotation) if get_origin(info.annotation) is Literal else ()),
        read_only=is_fixed,
    )
    return tuple(filter(None, value or ())) if is_list else value  # an empty list comes as None
