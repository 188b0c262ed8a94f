"""Declared parameters: their range, their meaning, and a reason when a value is refused."""

from typing import Literal

import pytest
import rclpy
from pydantic import Field
from rclpy.node import Node
from rclpy.parameter import Parameter

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.nodes.parameters import declare, declare_parameters


@pytest.fixture
def node(domain, tmp_path, monkeypatch):
    """Makes a node that was given parameters on its command line."""
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    made = []

    def make(*parameters):
        args = ["test", "--ros-args", *(word for parameter in parameters for word in ("-p", parameter))]
        rclpy.init(args=args, domain_id=domain)
        made.append(Node("tested"))
        return made[-1]

    yield make
    for one in made:
        one.destroy_node()
    rclpy.try_shutdown()


def refusal(call):
    with pytest.raises(InputError) as caught:
        call()
    assert "\n" not in str(caught.value)
    return caught.value


def test_a_default_is_used_and_described(node):
    tested = node()
    assert declare(tested, "rate", 2.0, "beats a second", low=0.5, high=4.0) == 2.0
    told = tested.describe_parameter("rate")
    assert told.description == "beats a second"
    assert (told.floating_point_range[0].from_value, told.floating_point_range[0].to_value) == (0.5, 4.0)
    assert told.read_only


@pytest.mark.parametrize("value", [0.5, 4.0])
def test_the_bounds_of_a_number_are_allowed(node, value):
    assert declare(node(f"rate:={value}"), "rate", 2.0, "beats a second", low=0.5, high=4.0) == value


@pytest.mark.parametrize("value", [0.499, 4.001, -1.0, 1e12])
def test_a_number_outside_its_range_is_refused_with_the_reason(node, value):
    error = refusal(lambda: declare(node(f"rate:={value}"), "rate", 2.0, "beats a second", low=0.5, high=4.0))
    assert error.where == "parameter rate"
    assert "out of range Min: 0.5, Max: 4.0" in error.what
    assert "beats a second" in error.mend


@pytest.mark.parametrize(("value", "is_allowed"), [(-1, False), (0, True), (7, True), (8, False)])
def test_a_whole_number_has_a_range_too(node, value, is_allowed):
    tested = node(f"seed:={value}")
    if is_allowed:
        assert declare(tested, "seed", 3, "of random numbers", low=0, high=7) == value
    else:
        assert "Min: 0, Max: 7" in refusal(lambda: declare(tested, "seed", 3, "of", low=0, high=7)).what


def test_one_bound_is_enough(node):
    assert declare(node("rate:=1e200"), "rate", 2.0, "beats", low=0.5) == 1e200


def test_a_text_must_be_one_of_the_choices(node):
    error = refusal(lambda: declare(node("clock:=sundial"), "clock", "wall", "of the run", choices=("wall", "sim")))
    assert str(error) == "parameter clock: 'sundial' is not allowed; choose one of wall, sim"


def test_the_choices_are_told_to_whoever_asks(node):
    tested = node("clock:=sim")
    assert declare(tested, "clock", "wall", "of the run", choices=("wall", "sim")) == "sim"
    assert tested.describe_parameter("clock").additional_constraints == "one of wall, sim"


@pytest.mark.parametrize(("given", "default"), [("rate:=fast", 2.0), ("rate:=[1.0]", 2.0), ("rate:=1.5", 2)])
def test_a_value_of_another_type_is_refused_with_the_name_said_once(node, given, default):
    error = refusal(lambda: declare(node(given), "rate", default, "beats a second"))
    assert error.where == "parameter rate"
    assert "expecting type" in error.what
    assert not error.what.endswith("rate")
    assert "beats a second" in error.mend


def test_a_flag_has_no_range(node):
    assert declare(node("on:=false"), "on", True, "whether it is on") is False


def test_read_only_is_refused_at_run_time_and_the_rest_obeys_its_range(node):
    tested = node()
    declare(tested, "fixed", 1.0, "for good", low=0.0, high=2.0)
    declare(tested, "free", 1.0, "at any time", low=0.0, high=2.0, read_only=False)
    results = [
        tested.set_parameters([Parameter(name, value=value)])[0]
        for name, value in (("fixed", 0.5), ("free", 3.0), ("free", 0.5))
    ]
    assert [result.successful for result in results] == [False, False, True]
    assert "read-only" in results[0].reason
    assert "out of range" in results[1].reason
    assert tested.get_parameter("free").value == 0.5


class Settings(Parameters):
    rate: float = Field(2.0, ge=0.5, le=4.0, description="beats a second")
    clock: Literal["wall", "sim"] = Field("wall", description="of the run")
    names: tuple[str, ...] = Field((), description="who is waited for")


def test_a_model_declares_its_fields_with_meaning_range_and_choices(node):
    tested = node("clock:=sim", "names:=[a, b]")
    assert declare_parameters(tested, Settings) == Settings(clock="sim", names=("a", "b"))
    told = tested.describe_parameter("rate")
    assert (told.description, told.floating_point_range[0].to_value, told.read_only) == ("beats a second", 4.0, True)
    assert tested.describe_parameter("clock").additional_constraints == "one of wall, sim"


def test_a_model_that_nobody_sets_is_its_defaults(node):
    tested = node()
    assert declare_parameters(tested, Settings, is_fixed=False) == Settings()
    assert not tested.describe_parameter("rate").read_only


@pytest.mark.parametrize("given", ["rate:=5.0", "clock:=sundial", "names:=3"])
def test_a_model_refuses_what_its_fields_refuse(node, given):
    assert refusal(lambda: declare_parameters(node(given), Settings)).where == f"parameter {given.split(':')[0]}"
