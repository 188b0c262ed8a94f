"""Classes from outside: what is refused before one is used, how it is made, and what is said when it fails."""

from typing import Protocol

import pytest
from pydantic import Field

from roadmend.core.errors import ForeignError, InputError
from roadmend.core.foreign import ForeignClass, blamed_on, check_object, trouble_of
from roadmend.core.parameters import NoParameters, Parameters


class Walker(Protocol):
    name: str

    def walk(self, where, how): ...


class Settings(Parameters):
    pace: float = Field(1.0, description="[m/s]")


class Plain:
    name = "plain"

    def walk(self, where, how):
        return where


class Set(Plain):
    def __init__(self, parameters: Settings | None = None, seed: int = 0, more=3):
        self.parameters, self.seed, self.more = parameters, seed, more


def check(thing):
    return ForeignClass.check("walker x:Y", thing, Walker, ["parameters", "seed"])


def with_constructor(function):
    return type("Made", (Plain,), {"__init__": function})


def test_it_gets_what_its_constructor_takes():
    assert check(Plain).parameters is NoParameters
    assert check(Plain).make(parameters=None, seed=4).name == "plain"
    made = check(Set).make(parameters=Settings(pace=2.0), seed=4)
    assert check(Set).parameters is Settings
    assert (made.parameters.pace, made.seed, made.more) == (2.0, 4, 3)


class Required(Parameters):
    pace: float


def takes(self, parameters: Required):
    pass


def untold(self, parameters):
    pass


def unresolved(self, parameters: "Nowhere"):  # noqa: F821
    pass


@pytest.mark.parametrize(
    ("thing", "said"),
    [
        (Plain(), "is no class but a Plain"),
        (len, "is no class but a builtin_function_or_method"),
        (type("Lame", (), {"name": "x"}), "has no method walk(where, how)"),
        (type("Lame", (), {"walk": 3}), "has no method walk(where, how)"),
        (type("Lame", (), {"walk": lambda self, where: 0}), "its method walk cannot be called as walk(where, how)"),
        (type("Lame", (), {"walk": lambda self, a, b, c: 0}), "its method walk cannot be called"),
        (type("Lame", (), {"walk": staticmethod(lambda where: 0)}), "its method walk cannot be called"),
        (with_constructor(lambda self, model: None), "its constructor wants 'model', which nobody gives"),
        (with_constructor(takes), "its parameter 'pace' has no default"),
        (with_constructor(untold), "says not what can be set"),
        (with_constructor(unresolved), "annotations cannot be read (NameError"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(thing, said):
    with pytest.raises(InputError) as caught:
        check(thing)
    assert str(caught.value).startswith("walker x:Y: ")
    assert said in str(caught.value)


@pytest.mark.parametrize(
    "walk",
    [
        lambda self, where, how: 0,
        lambda self, where, how, more=1: 0,
        lambda self, *everything: 0,
        staticmethod(lambda where, how: 0),
        classmethod(lambda cls, where, how: 0),
    ],
)
def test_every_way_to_write_a_method_that_can_be_called_will_do(walk):
    assert check(type("Fine", (), {"name": "fine", "walk": walk})).make(parameters=None, seed=0).name == "fine"


def fails(self):
    raise OSError("no model")


@pytest.mark.parametrize(
    ("thing", "said"),
    [
        (with_constructor(fails), f"cannot be made: OSError: no model ({__file__} line "),
        (type("Nameless", (), {"walk": Plain.walk}), "has no attribute 'name' that is a text"),
        (type("Numbered", (), {"walk": Plain.walk, "name": 3}), "has no attribute 'name' that is a text"),
    ],
)
def test_one_that_cannot_be_made_is_refused_in_one_line(thing, said):
    with pytest.raises(InputError) as caught:
        check(thing).make(parameters=None, seed=0)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("thing", "said"),
    [
        (type("Lame", (), {"name": "x"})(), "has no method walk(where, how)"),
        (type("Nameless", (), {"walk": Plain.walk})(), "has no attribute 'name' that is a text"),
        (None, "has no method walk(where, how)"),
    ],
)
def test_an_object_is_looked_at_as_a_class_is(thing, said):
    check_object("walker x:Y", with_constructor(lambda self, model: None)(3), Walker)  # how it was made is no matter
    with pytest.raises(InputError) as caught:
        check_object("walker x:Y", thing, Walker)
    assert str(caught.value).startswith("walker x:Y: ")
    assert said in str(caught.value)


def test_what_it_refuses_itself_is_passed_on():
    def refuses(self):
        raise InputError("its model", "is not there", "train one")

    with pytest.raises(InputError, match="its model: is not there; train one"):
        check(with_constructor(refuses)).make(parameters=None, seed=0)


def test_whatever_it_raises_is_blamed_on_it_in_one_line():
    with pytest.raises(ForeignError) as caught, blamed_on("walker x:Y", "walk"):
        raise ValueError("two\nlines")
    assert str(caught.value).startswith("walker x:Y: failed in walk: ValueError: two lines (")
    with pytest.raises(InputError), blamed_on("walker x:Y", "walk"):
        raise InputError("a", "b", "c")


def test_trouble_is_told_with_the_last_place_in_the_users_own_code():
    with pytest.raises(ValueError) as caught:
        Settings(pace="fast")
    assert trouble_of(caught.value).endswith(f"({__file__} line {caught.tb.tb_lineno})")
    assert trouble_of(KeyError()) == "KeyError"
