from pathlib import Path
from typing import Literal, get_origin

import pytest
import yaml

from roadmend.core.errors import InputError
from roadmend.core.repair import RepairStatus
from roadmend.repair.parameters import GuardParameters
from roadmend.repair.registry import METHODS, make_repairer

from .playground import Box, keep_on, scene_of, straight_route

CONFIG = Path(__file__).parents[2] / "config" / "repair"
MODELS = {name: entry.parameters for name, entry in METHODS.items()} | {"guard": GuardParameters}
FIELDS = [(name, field) for name, model in MODELS.items() for field in model.model_fields]


@pytest.mark.parametrize("name", METHODS)
def test_each_method_answers(name):
    repairer = make_repairer(name, seed=4)
    assert repairer.name == name
    repairer.reset(straight_route())
    for tick in range(5):
        scene = scene_of([Box(1, 30.0, 0.0, speed=5.0)], 0.05 * tick)
        repair = repairer.step(scene, keep_on(scene))
        assert repair.status in {RepairStatus.PASS, RepairStatus.REPAIRED, RepairStatus.RESET}


@pytest.mark.parametrize("name", METHODS)
def test_the_same_scenes_give_the_same_repairs(name):
    def run():
        repairer = make_repairer(name)
        repairer.reset(straight_route())
        scenes = [scene_of([Box(1, 40.0 - tick, 0.0, speed=3.0)], 0.05 * tick) for tick in range(30)]
        return [repr(repairer.step(scene, keep_on(scene))) for scene in scenes]

    assert run() == run()


@pytest.mark.parametrize("name", MODELS)
def test_the_configuration_files_hold_the_defaults(name):
    values = yaml.safe_load((CONFIG / f"{name}.yaml").read_text()) or {}
    assert values == MODELS[name]().model_dump()


def test_there_is_no_configuration_without_a_method():
    assert {path.stem for path in CONFIG.glob("*.yaml")} == set(MODELS)


@pytest.mark.parametrize(("name", "field"), FIELDS)
def test_every_parameter_has_a_meaning_and_a_range(name, field):
    info = MODELS[name].model_fields[field]
    assert info.description
    if info.annotation not in (bool, str) and get_origin(info.annotation) is not Literal:  # that is its own range
        kinds = {type(bound).__name__ for bound in info.metadata}
        assert kinds & {"Ge", "Gt"}
        assert kinds & {"Le", "Lt"}


@pytest.mark.parametrize("name", ["magic", "", "RSS"])
def test_an_unknown_method_is_refused_with_the_known_ones(name):
    with pytest.raises(InputError, match=f"there is no .*{', '.join(METHODS)}"):
        make_repairer(name)


def test_an_unknown_parameter_is_refused_with_the_known_ones():
    with pytest.raises(InputError, match=r"rss\.roh: is unknown, did you mean rho\?; known are: rho"):
        make_repairer("rss", {"roh": 1.0})
    with pytest.raises(InputError, match="known are: none"):
        make_repairer("none", {"rho": 1.0})


@pytest.mark.parametrize("bad", [-0.1, 3.1, float("nan"), float("inf"), "0.5", None])
def test_a_bad_value_is_refused_with_its_meaning(bad):
    with pytest.raises(InputError, match=r"rss\.rho: .*response time"):
        make_repairer("rss", {"rho": bad})


def test_a_bad_guard_parameter_is_refused():
    with pytest.raises(InputError, match=r"guard\.budget"):
        make_repairer("none", guard={"budget": 0.0})
    assert make_repairer("none", guard={"budget": 0.02}).parameters.budget == 0.02


def test_parameters_are_frozen():
    with pytest.raises(ValueError, match="frozen"):
        GuardParameters().budget = 1.0
