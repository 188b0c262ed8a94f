"""Parameters and parameters: strict, and refused in one line with the nearest name."""

from dataclasses import dataclass
from typing import Annotated, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field, SecretStr, TypeAdapter, ValidationError

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.settings import check_parameters, check_settings, describe, read_settings


class Wheel(Parameters):
    radius: float = Field(0.3, gt=0.0, le=1.0, description="radius [m]")


class Track(BaseModel):
    model_config = ConfigDict(extra="forbid")

    kind: Literal["track"] = "track"
    length: float = 1.0


class Wing(BaseModel):
    kind: Literal["wing"] = "wing"


class Vehicle(Parameters):
    speed: float = Field(ge=0.0, description="speed [m/s]")
    wheels: tuple[Wheel, ...] = ()
    spare: Wheel | None = None
    by_name: dict[str, Wheel] = Field({})
    moved_by: Annotated[Wing | Track, Field(discriminator="kind")] = Wing()


@dataclass
class Person:
    __pydantic_config__ = ConfigDict(extra="forbid")

    name: str


def refusal(content):
    with pytest.raises(InputError) as caught:
        check_settings(content, Vehicle, "car.yaml", "see elsewhere")
    return str(caught.value)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"speed": 1.0, "sped": 2.0}, "field sped is unknown, did you mean speed?"),
        ({"speed": 1.0, "colour": "red"}, "field colour is unknown"),
        ({"speed": 1.0, "wheels": [{"raduis": 1}]}, "field wheels[0].raduis is unknown, did you mean radius?"),
        ({"speed": 1.0, "spare": {"raduis": 1}}, "field spare.raduis is unknown, did you mean radius?"),
        ({"speed": 1.0, "by_name": {"x": {"raduis": 1}}}, "field by_name.x.raduis is unknown, did you mean radius?"),
        (
            {"speed": 1.0, "moved_by": {"kind": "track", "lenght": 1}},
            "field moved_by.track.lenght is unknown, did you mean length?",
        ),
        ({}, "field speed is missing"),
        ({"speed": "fast"}, 'field speed: input should be a valid number (got "fast")'),
        (
            {"speed": -1.0, "spare": 1},
            "field speed: input should be greater than or equal to 0 (got -1.0) (and 1 more)",
        ),
        ({"speed": float("inf")}, "field speed: input should be a finite number (got Infinity)"),
        (7, "input should be a valid dictionary or instance of Vehicle (got 7)"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(content, said):
    assert refusal(content) == f"car.yaml: {said}; see elsewhere"


def test_lists_become_tuples_and_nothing_else_is_converted():
    assert check_settings({"speed": 1, "wheels": [{}]}, Vehicle, "", "") == Vehicle(speed=1.0, wheels=(Wheel(),))
    with pytest.raises(InputError, match="valid number"):
        check_settings({"speed": "1"}, Vehicle, "", "")


def test_a_file(tmp_path):
    path = tmp_path / "car.yaml"
    path.write_text("speed: 2\nspare: {radius: 0.4}\n")
    assert read_settings(path, Vehicle, "see elsewhere") == Vehicle(speed=2.0, spare=Wheel(radius=0.4))
    path.write_text("speed: 2\nspare: {radius: 4}\n")
    with pytest.raises(InputError, match=r"car\.yaml: field spare\.radius: input should be less than or equal to 1"):
        read_settings(path, Vehicle, "see elsewhere")


def test_parameters_are_named_as_they_are_set():
    assert check_parameters({"radius": 0.5}, Wheel, "wheel") == Wheel(radius=0.5)
    assert check_parameters(None, Wheel, "wheel") == Wheel()
    with pytest.raises(InputError) as caught:
        check_parameters({"raduis": 0.5}, Wheel, "wheel")
    assert str(caught.value) == "wheel.raduis: is unknown, did you mean radius?; known are: radius"
    with pytest.raises(InputError) as caught:
        check_parameters({"radius": 0.0}, Wheel, "wheel")
    assert str(caught.value) == "wheel.radius: input should be greater than 0 (got 0.0); radius [m]"


def test_a_secret_is_not_said():
    class Door(Parameters):
        model_config = ConfigDict(hide_input_in_errors=True)

        key: SecretStr

    with pytest.raises(InputError) as caught:
        check_settings({"key": 12345}, Door, "door.yaml", "mend")
    assert "12345" not in str(caught.value)


def test_a_dataclass_that_refuses_unknown_names():
    with pytest.raises(ValidationError) as caught:
        TypeAdapter(list[Person]).validate_python([{"nam": "x", "name": "y"}])
    assert describe(caught.value, list[Person]) == "field [0].nam is unknown, did you mean name?"
