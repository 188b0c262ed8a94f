"""Message classes by the name of their type."""

import importlib
from typing import Any

from roadmend.core.errors import InputError


def message_class(topic: str, type_name: str) -> Any:
    """The class of a topic's messages.

    Args:
        topic: the topic, for the error.
        type_name: package/msg/Name.

    Raises:
        InputError: the type's package cannot be imported or has no such message.
    """
    package, _, kind = type_name.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.msg"), kind)
    except (ImportError, AttributeError) as error:
        raise InputError(topic, f"its type cannot be imported ({error})", f"install the package {package}") from error
