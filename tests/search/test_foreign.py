"""A technique and a family of one's own."""

import pytest

from roadmend.core.errors import ForeignError, InputError
from roadmend.search.campaign import Campaign
from roadmend.search.evaluation import Subject
from roadmend.search.registry import make_technique, read_technique_parameters
from roadmend.world.families import FAMILIES, family_of, sample_scenario

from .toy import SPACE

TECHNIQUE = """
import numpy as np

from roadmend.core.parameters import Parameters
from roadmend.search.evaluation import Trial
from roadmend.world.space import sample

class Settings(Parameters):
    batch: int = 3

class Draws:
    def __init__(self, space, generator, parameters: Settings):
        self.space, self.generator, self.batch = space, generator, parameters.batch
    def propose(self):
        return [sample(self.space, self.generator) for _ in range(self.batch)]
    def learn(self, trials):
        assert all(isinstance(trial, Trial) for trial in trials)

class Numbers(Draws):
    def propose(self):
        numbers = {"speed": np.float32(2.5), "lanes": np.int64(3), "kind": np.str_("car"), "fixed": np.True_}
        return [super().propose()[0] | numbers]

class Arrays(Draws):
    def propose(self):
        return [{"speed": np.zeros(2)}]

class Empty(Draws):
    def propose(self):
        return []

class Fails(Draws):
    def propose(self):
        return self.nothing
"""
FAMILY = """
from roadmend.world.families import FAMILIES, Family
from roadmend.world.space import Choice, Uniform, Whole

SPACE = {"a": Uniform(0.0, 1.0)}
CROSSING = Family("mine", "my crossing", FAMILIES["S3"].space, FAMILIES["S3"].build)
EMPTY = Family("mine", "nothing", SPACE, lambda parameters, name, seed: None)
FAILS = Family("mine", "nothing", SPACE, lambda parameters, name, seed: 1 / 0)
NO_SPACE, LIST, PAIR, TURNED, UNWEIGHTED, NUMBERED = (
    Family("mine", "nothing", space, FAMILIES["S3"].build)
    for space in (
        {}, [Uniform(0.0, 1.0)], {"a": (0, 1)}, {"a": Whole(5, 2)}, {"a": Choice({"x": 0.0})}, {1: Uniform(0.0, 1.0)}
    )
)
other = 3
"""


def test_a_technique_draws_by_the_seed(own):
    given = f"{own(TECHNIQUE)}:Draws"
    first, again, other = (make_technique(given, SPACE, seed).propose() for seed in (1, 1, 2))
    assert len(first) == 3
    assert first == again != other
    chosen = read_technique_parameters(given, {"batch": 5})
    assert len(make_technique(given, SPACE, 1, chosen).propose()) == 5
    with pytest.raises(InputError, match=r"did you mean batch\?"):
        read_technique_parameters(given, {"bach": 5})


def test_a_technique_that_fails_is_said_in_one_line(own):
    name = own(TECHNIQUE)
    with pytest.raises(ForeignError, match=f"technique {name}:Empty: proposed no points"):
        make_technique(f"{name}:Empty", SPACE, 1).propose()
    with pytest.raises(ForeignError, match=f"technique {name}:Fails: failed in propose: AttributeError: .*line 34"):
        make_technique(f"{name}:Fails", SPACE, 1).propose()
    technique = make_technique(f"{name}:Draws", SPACE, 1)
    with pytest.raises(ForeignError, match="failed in learn: AssertionError"):
        technique.learn([3])


def test_a_technique_may_propose_numbers_of_numpy_and_no_arrays(own):
    name = own(TECHNIQUE)
    (point,) = make_technique(f"{name}:Numbers", SPACE, 1).propose()
    assert (point["speed"], point["lanes"], point["kind"], point["fixed"]) == (2.5, 3, "car", True)
    assert {type(value) for value in point.values()} <= {float, int, str, bool}
    with pytest.raises(ForeignError, match=r"proposed 'speed' as ndarray; answer with numbers and texts"):
        make_technique(f"{name}:Arrays", SPACE, 1).propose()


@pytest.mark.parametrize(
    ("family", "words"),
    [
        ("NO_SPACE", "its space is no dictionary that holds a dimension"),
        ("LIST", "its space is no dictionary"),
        ("PAIR", "its space has 'a', which is tuple"),
        ("NUMBERED", "its space has 1, which is Uniform"),
        ("TURNED", "failed in drawing 'a': ValueError: empty range"),
        ("UNWEIGHTED", "failed in drawing 'a': ValueError"),
    ],
)
def test_a_family_with_a_malformed_space_is_said_in_one_line(own, family, words):
    name = own(FAMILY)
    with pytest.raises(InputError, match=f"family {name}:{family}: {words}") as caught:
        sample_scenario(f"{name}:{family}", 1)
    assert "\n" not in str(caught.value)


def test_a_search_with_it_is_another_when_its_code_changes(own):
    name, other = own(TECHNIQUE), own(TECHNIQUE.replace("range(self.batch)", "range(self.batch + 1)"))
    codes = set()
    for given in (f"{name}:Draws", f"{other}:Draws"):
        campaign = Campaign(Subject("S5", "modular", "rss", 1), given, read_technique_parameters(given))
        codes.add(campaign.settings["code"])
        assert campaign.name(3) == "S5-modular-rss-Draws-1-00003"
    assert len(codes) == 2


def test_a_family_is_drawn_from_and_searched_in(own):
    given = f"{own(FAMILY)}:CROSSING"
    scenario = sample_scenario(given, 4)
    assert scenario.name == "CROSSING-4"
    assert scenario == sample_scenario(given, 4)
    assert family_of(given).space == FAMILIES["S3"].space
    assert Subject(given, "modular", "rss", 1).scenario(dict(scenario_point()), "x").name == "x"


def scenario_point():
    import random

    from roadmend.world.space import sample

    return sample(FAMILIES["S3"].space, random.Random(1))


def test_what_is_no_family_or_builds_nothing_is_said_in_one_line(own):
    name = own(FAMILY)
    with pytest.raises(InputError, match=f"family {name}:other: is no Family but int"):
        sample_scenario(f"{name}:other", 1)
    with pytest.raises(ForeignError, match="build answered with NoneType; answer with a Scenario"):
        sample_scenario(f"{name}:EMPTY", 1)
    with pytest.raises(ForeignError, match="failed in build: ZeroDivisionError"):
        sample_scenario(f"{name}:FAILS", 1)
