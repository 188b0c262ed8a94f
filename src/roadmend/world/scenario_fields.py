"""The kinds of field that the parts of a scenario have in common, and what is left out where they are written."""

from typing import Annotated

from pydantic import Field

FILE_NAME = r"^[^\x00]+$"

Metres = Annotated[float, Field(ge=0.0, le=100_000.0, allow_inf_nan=False)]
Seconds = Annotated[float, Field(ge=0.0, le=86_400.0, allow_inf_nan=False)]
Speed = Annotated[float, Field(ge=0.0, le=70.0, allow_inf_nan=False, description="[m/s]")]
Coordinate = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False, strict=True, description="[m]")]
EdgeList = Annotated[list[str], Field(min_length=1, description="road network edges in driving order")]


def is_none(value: object) -> bool:
    """Whether nothing is given."""
    return value is None


def is_zero(value: object) -> bool:
    """Whether it is nought."""
    return value == 0.0


def is_false(value: object) -> bool:
    """Whether it is not so."""
    return value is False


def is_empty(value: object) -> bool:
    """Whether there is none."""
    return value == []
