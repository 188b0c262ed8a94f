"""What all parts of a scenario have in common."""

import json
from functools import cache
from typing import Annotated, Any, get_args

from pydantic import BaseModel, ConfigDict, Field, model_validator

Identifier = Annotated[str, Field(pattern=r"^[A-Za-z0-9_.\-]+$", description="letters, digits, '_', '.' and '-'")]


class ScenarioModel(BaseModel):
    """Base of all scenario parts: unknown fields are errors, values do not change after reading."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def _truth_is_no_number(cls, values: Any) -> Any:
        """YAML reads yes and on as true, which would pass for 1 m/s."""
        if isinstance(values, dict):
            for name, value in values.items():
                if isinstance(value, bool) and name in _numbers_of(cls):
                    raise ValueError(f"{name}: {json.dumps(value)} is no number")
        return values


@cache
def _numbers_of(model: type[BaseModel]) -> frozenset[str]:
    """The fields of a model that hold a number, and no truth value."""
    fields = model.model_fields.items()
    kinds = {name: {*get_args(field.annotation)} or {field.annotation} for name, field in fields}
    return frozenset(name for name, kind in kinds.items() if kind & {int, float} and bool not in kind)
