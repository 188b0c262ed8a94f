"""What a user gives for a policy or a repair method: names, classes and objects get the same checks."""

import pytest

from roadmend.api.given import name_of, policy_of, repairer_of, title_of
from roadmend.core.command import Decision
from roadmend.core.errors import ForeignError, InputError
from roadmend.core.plain_moment import plain_moment


def test_names_classes_and_objects_decide_alike(theirs):
    policies, _ = theirs
    moment = plain_moment()
    decided = []
    for given in (f"{policies.__name__}:Careful", policies.Careful, policies.Careful()):
        policy = policy_of(given)
        assert policy.name == title_of(given) == f"{policies.__name__}:Careful"
        policy.reset(moment.route)
        decided.append(policy.step(moment.scene).command)
    assert decided[0] == decided[1] == decided[2]


def test_a_class_gets_parameters_and_seed(theirs):
    _, repairs = theirs
    moment = plain_moment()
    for distance, brakes in ((8.0, False), (25.0, True)):
        repairer = repairer_of(repairs.Near, {"distance": distance}, seed=4)
        assert repairer._method.method.seed == 4
        repairer.reset(moment.route)
        assert repairer.step(moment.scene, moment.decision).intervened is brakes


def test_an_object_keeps_what_it_was_made_with(theirs):
    _, repairs = theirs
    moment = plain_moment()
    repairer = repairer_of(repairs.Near(repairs.Settings(distance=25.0)))
    repairer.reset(moment.route)
    assert repairer.step(moment.scene, moment.decision).intervened


@pytest.mark.parametrize(
    ("attribute", "of_class", "said"),
    [
        ("Never", True, "cannot answer a plain scene: its step at 0.00 s answered with NoneType"),
        ("Never", False, "cannot answer a plain scene: its step at 0.00 s answered with NoneType"),
    ],
)
def test_a_policy_that_cannot_answer_is_refused(theirs, attribute, of_class, said):
    policies, _ = theirs
    kind = getattr(policies, attribute)
    with pytest.raises(InputError) as caught:
        policy_of(kind if of_class else kind())
    assert str(caught.value).startswith(f"policy {policies.__name__}:{attribute}: ")
    assert said in str(caught.value)


@pytest.mark.parametrize("of_class", [True, False])
def test_one_that_lacks_a_method_or_a_name_is_refused(of_class):
    class Lame:
        name = "lame"

        def reset(self, route):
            pass

    class Nameless(Lame):
        name = 3

        def step(self, scene):
            pass

    for kind, said in (
        (Lame, "has no method step(scene); add it"),
        (Nameless, "has no attribute 'name' that is a text"),
    ):
        with pytest.raises(InputError, match=r"Lame|Nameless") as caught:
            policy_of(kind if of_class else kind())
        assert said in str(caught.value)
    with pytest.raises(InputError, match=r"has no method propose\(scene, decision\)"):
        repairer_of(Lame if of_class else Lame())


def test_what_is_nothing_of_the_kind_is_refused():
    with pytest.raises(InputError, match="policy builtins:int: has no method reset"):
        policy_of(3)
    with pytest.raises(InputError, match="there is no 'modulr', did you mean modular"):
        policy_of("modulr")


def test_parameters_are_checked_and_no_objects_affair(theirs):
    policies, repairs = theirs
    with pytest.raises(InputError, match=r"distanc.*did you mean distance"):
        repairer_of(repairs.Near, {"distanc": 3.0})
    with pytest.raises(InputError, match="is an object, which has its parameters"):
        repairer_of(repairs.Near(repairs.Settings()), {"distance": 3.0})
    with pytest.raises(InputError, match="is an object, which has its parameters"):
        policy_of(policies.Careful(), {"pace": 3.0})


def test_parameters_that_are_none_are_refused():
    for made in (policy_of, repairer_of):
        with pytest.raises(InputError, match="parameters: is no dictionary of values by name, but int"):
            made({policy_of: "modular", repairer_of: "rss"}[made], 3)


def test_what_fails_on_the_way_is_blamed_on_it(theirs):
    policies, repairs = theirs
    moment = plain_moment()
    late = moment.scene.__class__(2.0, moment.scene.ego, moment.scene.objects, moment.scene.signals)
    policy = policy_of(policies.Late())
    policy.reset(moment.route)
    with pytest.raises(ForeignError, match=r"Late: failed in step at 2.00 s: ZeroDivisionError.* line "):
        policy.step(late)
    repairer = repairer_of(repairs.Late(repairs.Settings()))
    repairer.reset(moment.route)
    repairer.step(late, Decision(moment.decision.command, moment.decision.trajectory))
    assert "KeyError: 'lost'" in repairer.first_fault


def test_only_what_any_process_finds_again_has_a_name(theirs):
    policies, _ = theirs

    class Local:
        pass

    assert name_of("modular") == "modular"
    assert name_of(policies.Careful) == f"{policies.__name__}:Careful"
    assert name_of(policies.Careful()) == name_of(Local) == ""
    assert title_of(Local()).endswith("<locals>.Local")
