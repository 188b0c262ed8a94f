"""``roadmend list``: everything that can be named, where it comes from, and what of it can be set."""

import json
from collections.abc import Mapping
from typing import Any

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.options import JSON
from roadmend.cli.output import show_rows
from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.registry import OWN, Found, Registry
from roadmend.language.models import BACKEND_REGISTRY
from roadmend.networks.checkpoint import SUFFIX, load_checkpoint, models_folder
from roadmend.policies.registry import POLICY_REGISTRY
from roadmend.repair.registry import METHOD_REGISTRY
from roadmend.search.registry import TECHNIQUE_REGISTRY
from roadmend.world.families import FAMILY_REGISTRY

Row = Mapping[str, Any]
_REGISTRIES: Mapping[str, Registry[Any]] = {
    "policies": POLICY_REGISTRY,
    "methods": METHOD_REGISTRY,
    "techniques": TECHNIQUE_REGISTRY,
    "families": FAMILY_REGISTRY,
    "backends": BACKEND_REGISTRY,
}
_MODELS = "models"


@click.command(
    "list",
    cls=ExampleCommand,
    examples=["roadmend list policies", "roadmend list methods adreft rss", "roadmend list models --json"],
)
@click.argument("kind", metavar="KIND", type=click.Choice([*_REGISTRIES, _MODELS]))
@click.argument("names", nargs=-1)
@JSON
def list_names(kind: str, names: tuple[str, ...], *, as_json: bool) -> int:
    """Show what there is of a kind, where it comes from and what of it can be set.

    KIND is one of policies, methods, techniques, families, backends, models. NAMES, to show only those, may be code of yours, package.module:Class. The exit code is 1 if an installed package offers something that
    cannot be used.
    """
    if kind == _MODELS:
        if names:
            raise InputError("NAMES", "go with a kind that has parameters", "leave them out")
        rows, faults = _models(), []
    else:
        registry = _REGISTRIES[kind]
        found = [registry.find(name) for name in names] if names else [*registry]
        faults = [str(each) for each in found if isinstance(each, InputError)]
        rows = [_row(each) for each in found if isinstance(each, Found)]
    if as_json:
        click.echo(json.dumps(rows, indent=2))
    elif kind == _MODELS:
        show_rows([("model", "kind", "SHA-256"), *((row["name"], row["kind"], row["sha256"]) for row in rows)])
    else:
        show_rows([("name", "origin", "parameters"), *((row["name"], row["origin"], _said(row)) for row in rows)])
    for fault in faults:
        click.echo(f"roadmend: {fault}", err=True)
    return 1 if faults else 0


def _row(found: Found[Any]) -> Row:
    """What is shown of something: by its kind of entry, parameters or dimensions, or nothing."""
    settings: list[dict[str, Any]] = []
    parameters = getattr(found.entry, "parameters", None)
    if isinstance(parameters, type) and issubclass(parameters, Parameters):
        defaults = parameters().model_dump(mode="json")
        for name, field in parameters.model_fields.items():
            settings.append({"name": name, "default": defaults[name], "meaning": field.description or ""})
    title = getattr(found.entry, "title", "")
    dimensions = len(getattr(found.entry, "space", ()))
    about = {"title": title, "dimensions": dimensions} if title else {}
    return {"name": found.given, "origin": found.origin, **about, "parameters": settings}


def _said(row: Row) -> str:
    if "title" in row:
        return f"{row['title']}, {row['dimensions']} dimensions"
    return ", ".join(f"{each['name']}={each['default']}" for each in row["parameters"]) or "-"


def _models() -> list[Row]:
    """The models that ship."""
    rows: list[Row] = []
    for path in sorted(models_folder().glob(f"*{SUFFIX}")):
        model = load_checkpoint(path)
        rows.append({"name": path.stem, "origin": OWN, "kind": model.header["kind"], "sha256": model.digest})
    return rows
