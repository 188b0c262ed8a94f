"""Words, makes and models to body classes."""

import pytest

from roadmend.safe.dsl import DslModel
from roadmend.safe.reading.body_class import _table, classify, find_names
from roadmend.safe.reading.text import name_vehicles, numerals_to_digits


@pytest.mark.parametrize(
    ("description", "model"),
    [
        ("a 1997 pontiac grand am, 4-door sedan", DslModel.SEDAN),
        ("a 1999 dodge ram conversion van", DslModel.MINIVAN),
        ("a 2004 dodge ram 1500", DslModel.PICKUP),
        ("a tractor pulling one trailer", DslModel.SEMI_TRUCK),
        ("a 1998 international tractor-trailer", DslModel.SEMI_TRUCK),
        ("a pickup truck pulling a utility trailer", DslModel.PICKUP),
        ("a 2016 honda crv", DslModel.SUV),
        ("a 2016 honda cr-v", DslModel.SUV),
        ("a 2010 ford f250", DslModel.PICKUP),
        ("a chevy tahoe", DslModel.SUV),
        ("a mazda 3, 4-door", DslModel.SEDAN),
        ("a white box truck", DslModel.SEMI_TRUCK),
        ("a marked police car", DslModel.SEDAN),
        ("a ford truck", DslModel.PICKUP),
        ("a truck towing a semi-trailer", DslModel.SEMI_TRUCK),
        ("a harley-davidson motorcycle", None),
    ],
)
def test_classes(description, model):
    assert classify(description).model is model


@pytest.mark.parametrize("description", ["", "the driver", "a blue vehicle", "a lincoln avenue resident"])
def test_descriptions_that_say_little(description):
    body = classify(description)
    assert body is None or body.confidence <= 0.6


def test_every_model_of_the_table_is_found():
    for make, models in _table().items():
        for name, model in models.items():
            if name:
                found = find_names(f"a 2001 {make} {name}")
                assert found, (make, name)
                assert _table()[found[0].make][found[0].model] is model, (make, name, found)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("Vehicle one (V1 - case vehicle)", "v1 (v1 - case vehicle)"),
        ("Vehicles 1, 3, and 4 slowed", "v1, v3, and v4 slowed"),
        ("Vehicle #1's front", "v1's front"),
        ("Unit No. 2 and unit number three", "v2 and v3"),
        ("Vehicle A struck Vehicle B", "v1 struck v2"),
        ("the second vehicle", "v2"),
        ("a two-vehicle crash", "a two-vehicle crash"),
        ("the vehicle a deer hit", "the vehicle a deer hit"),
        ("car 2.5 m long", "car 2.5 m long"),
        ("Vehicle #1,2000 Ford", "v1,2000 ford"),
    ],
)
def test_names_of_vehicles(text, named):
    assert name_vehicles(text) == named


@pytest.mark.parametrize(
    ("words", "digits"), [("two-lane", "2-lane"), ("thirty-five", "35"), ("twenty one", "21"), ("often", "often")]
)
def test_numerals(words, digits):
    assert numerals_to_digits(words) == digits
