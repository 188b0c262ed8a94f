"""What every set of parameters is: the single source of names, defaults, ranges and meanings."""

from copy import copy
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, create_model, field_validator
from pydantic.fields import FieldInfo


class Parameters(BaseModel):
    """Base of parameters: frozen, strict, and deaf to unknown names; each field's description is its meaning."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _from_list(cls, value: Any) -> Any:
        """Neither YAML nor JSON nor ROS has tuples."""
        return tuple(map(cls._from_list, value)) if isinstance(value, list) else value


class NoParameters(Parameters):
    """Nothing can be set."""


AnyParameters = TypeVar("AnyParameters", bound=Parameters)


def with_defaults(model: type[AnyParameters], /, **defaults: Any) -> type[AnyParameters]:
    """The same parameters with other defaults."""
    fields: dict[str, Any] = {}
    for name, default in defaults.items():
        info = copy(model.model_fields[name])
        info.default = default
        fields[name] = (info.annotation, info)
    return create_model(model.__name__, __base__=model, __module__=model.__module__, **fields)


def bound_of(info: FieldInfo, name: str) -> float | None:
    """A bound of a field: what its constraints give under ``ge`` or ``le``."""
    return next((getattr(entry, name) for entry in info.metadata if getattr(entry, name, None) is not None), None)
