"""What every set of parameters is: the single source of names, defaults, ranges and meanings."""

from typing import Any

from pydantic import BaseModel, ConfigDict, field_validator


class Parameters(BaseModel):
    """Base of parameters: frozen, strict, and deaf to unknown names; each field's description is its meaning."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)

    @field_validator("*", mode="before")
    @classmethod
    def _from_list(cls, value: Any) -> Any:
        """Neither YAML nor JSON nor ROS has tuples."""
        return tuple(map(cls._from_list, value)) if isinstance(value, list) else value
