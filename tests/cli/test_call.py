"""The call that an account of figures names is the call that made them."""

import shlex
import shutil
from pathlib import Path

import click

from roadmend.cli.call import call_again
from roadmend.cli.main import run_group
from roadmend.cli.options import ModelType, NameType
from roadmend.cli.sera_cycle import cycle
from roadmend.cli.sera_tune import tune
from roadmend.networks.checkpoint import find_model
from roadmend.policies.registry import POLICY_REGISTRY

CALLS, PLACELESS = [], []


@click.group()
def tool():
    pass


@tool.command()
@click.argument("files", nargs=-1, type=click.Path(path_type=Path))
@click.option("--policy", "policies", multiple=True, default=["modular"])
@click.option("-k", "--count", type=int, default=20)
@click.option("--model", type=NameType(POLICY_REGISTRY))
@click.option("--network", type=ModelType())
@click.option("--limit", type=float)
@click.option("--work", type=click.Path(path_type=Path))
@click.option("--resume", is_flag=True)
@click.option("--tuned/--no-tuned", default=True)
@click.option("--out", type=click.Path(path_type=Path))
@click.option("--workers", type=int, default=1)
@click.option("--json", "as_json", is_flag=True)
def measure(**given):
    CALLS.append((call_again(always=("policies",)), given))
    PLACELESS.append(call_again(with_places=False))


def called(*words):
    assert run_group(tool, "tool", [*words]) == 0
    return CALLS.pop()


def test_what_was_given_is_told_and_so_is_what_is_always_told():
    assert called("measure")[0] == "./roadmend measure --policy modular"
    words = ["a b.yaml", "c.yaml", "--policy", "x", "--policy", "y:Z", "-k", "20", "--limit", "1234.5678", "--no-tuned"]
    told = "./roadmend measure 'a b.yaml' c.yaml --policy x --policy y:Z -k 20 --limit 1234.5678 --no-tuned"
    assert called("measure", *words)[0] == told


def test_where_it_goes_and_how_it_is_shown_is_not_told():
    aside = ["--out", "o", "--workers", "7", "--json", "--work", "w", "--resume"]
    assert called("measure", *aside)[0] == "./roadmend measure --policy modular"


def test_what_is_passed_on_tells_files_without_their_places(tmp_path):
    model = tmp_path / "my model.safetensors"
    shutil.copyfile(find_model("neural"), model)
    words = ["/home/me/a.yaml", "--policy", "x/y", "--model", str(model), "--network", str(model)]
    quoted = shlex.quote(str(model))
    assert called("measure", *words)[0] == (
        f"./roadmend measure /home/me/a.yaml --policy x/y --model {quoted} --network {quoted}"
    )
    name = "'my model.safetensors'"
    assert PLACELESS[-1] == f"./roadmend measure a.yaml --policy x/y --model {name} --network {name}"


def test_the_policies_that_are_tuned_are_told_without_their_places():
    for command in (tune, cycle):
        (policy,) = [each for each in command.params if each.name == "policy"]
        assert isinstance(policy.type, ModelType)


def test_the_call_that_is_told_means_the_same_again():
    first = called("measure", "a b.yaml", "--limit", "1e-7", "--tuned", "--policy", "x")
    assert called(*shlex.split(first[0])[1:]) == first
