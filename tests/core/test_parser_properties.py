"""Every parser of texts and every model of settings, given anything: a value or one line, never another exception."""

import importlib
import json
from functools import cache

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import BaseModel

from roadmend.core.errors import InputError
from roadmend.core.json_text import parse_json
from roadmend.core.settings import check_settings
from roadmend.core.yaml_file import parse_yaml
from roadmend.safe.dsl_file import dump_crash_scenario, parse_crash_scenario
from roadmend.safe.dsl_text import parse_text

QUIET = settings(max_examples=150, deadline=None, suppress_health_check=[*HealthCheck], derandomize=True)

MODELS = [  # what YAML files and parameters of nodes are checked against
    "roadmend.faults.campaign:FaultCampaign",
    "roadmend.world.scenario:Scenario",
    "roadmend.search.corpus_plan:CorpusPlan",
    "roadmend.training.adreft.configuration:TrainingConfiguration",
    "roadmend.training.imitation_configuration:ImitationConfiguration",
    "roadmend.training.few_shot_settings:FewShotSettings",
    "roadmend.repair.parameters:GuardParameters",
    "roadmend.repair.parameters:RssParameters",
    "roadmend.policies.parameters:ModularParameters",
]
leaves = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.integers(-(10**400), 10**400),
    st.floats(),
    st.text(max_size=20),
    st.sampled_from(["NaN", "1e999", "0x10", "~", "1:30", "\ud800", "\x00", "a\nb", "{x}", "__class__"]),
)
WORDS = ["<Scenario>:", "<Road network>:", "<Actors>:", "<Vehicle_1>:", "<Vehicle_99>:", "<Env>:", "<Collisions>:"]
WORDS += ["<Road type>: Straight", "<No. lanes>: 2", "<No. lanes>: -1", "<Model>: Sedan", "<Actions>: [", "<Time>: {}"]
WORDS += ["<Collision_1>:", "<Striking>: 1", "<Striking>: NaN", "<Speed_limit>: 1e9", "<Extra_x>: null", "<>:", ": <a>"]


def names_of(model):
    """Names of the fields of a model and of those within it."""
    found = set()
    for name, info in model.model_fields.items():
        found.add(name)
        kinds = [info.annotation, *getattr(info.annotation, "__args__", ())]
        for kind in kinds:
            if isinstance(kind, type) and issubclass(kind, BaseModel) and kind is not model:
                found |= names_of(kind)
    return found


@cache
def model_of(place):
    module, _, name = place.partition(":")
    return getattr(importlib.import_module(module), name)


def data_with(names):
    keys = st.sampled_from(sorted(names)) | st.text(max_size=8)
    return st.recursive(
        leaves, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(keys, inner, max_size=6), max_leaves=20
    )


def refused_in_a_line(call):
    try:
        call()
    except InputError as error:
        text = str(error)
        assert "\n" not in text
        assert len(text) < 2000


@pytest.mark.parametrize("place", MODELS)
def test_whatever_plain_data_a_model_of_settings_is_given_it_takes_or_refuses_in_a_line(place):
    model = model_of(place)

    @QUIET
    @given(data_with(names_of(model)))
    def check(content):
        refused_in_a_line(lambda: check_settings(content, model, "file.yaml", "mend it"))

    check()


@pytest.mark.parametrize("parse", [parse_json, parse_yaml])
@pytest.mark.parametrize("dump", [json.dumps, yaml.safe_dump])
def test_texts_that_were_cut_and_put_together_are_read_or_refused(parse, dump):
    @QUIET
    @given(data_with({"a", "<<"}), st.integers(0, 200), st.text(max_size=12), st.binary(max_size=4))
    def check(content, place, more, raw):
        try:
            text = dump(content)
        except (ValueError, yaml.YAMLError):  # an integer too long to print; a character that YAML has not
            return
        place %= len(text) + 1
        for one in (text, text[:place], text[:place] + more + text[place:]):
            refused_in_a_line(lambda one=one: parse(one, "file"))
            refused_in_a_line(lambda one=one: parse(one.encode("utf-8", "surrogatepass") + raw, "file"))

    check()


lines = st.tuples(st.integers(0, 8), st.sampled_from(WORDS) | st.text(max_size=30))
outlines = st.lists(lines, max_size=14).map(lambda told: "\n".join(" " * indent + words for indent, words in told))


@QUIET
@given(outlines)
def test_an_outline_of_a_crash_is_read_or_refused(text):
    refused_in_a_line(lambda: parse_text(text, "crash.dsl"))


@QUIET
@given(data_with({"road", "vehicles", "env", "collisions", "road_type", "num_lanes", "model", "action", "striking"}))
def test_a_crash_in_json_or_yaml_is_read_and_written_again_or_refused(content):
    for ending, dump in ((".json", json.dumps), (".yaml", yaml.safe_dump)):
        try:
            text = dump(content)
        except (ValueError, yaml.YAMLError):
            continue
        try:
            scenario = parse_crash_scenario(text, ending, "crash")
        except InputError as error:
            assert "\n" not in str(error)  # noqa: PT017
        else:
            dump_crash_scenario(scenario, ending)
