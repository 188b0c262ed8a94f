"""Who takes part in the benchmark of repair methods, and with which parameters and models."""

import hashlib
import json
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from roadmend.core.errors import InputError
from roadmend.core.settings import check_parameters, read_settings
from roadmend.core.source_digest import source_digest
from roadmend.policies.registry import POLICIES, make_policy
from roadmend.repair.registry import METHODS
from roadmend.training.tuned_file import TunedMethods

_ALWAYS = ("roadmend.repair.guard", "roadmend.world.corpus", "harness.case_jobs")

Group = Literal["reference", "control", "rival", "adreft", "variant", "ablation", "bound"]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class PlannedMethod(_Part):
    """A method of the benchmark: a repair method of the registry with parameters and perhaps a model."""

    title: str
    method: str
    group: Group
    tuned: bool = False
    parameters: dict[str, Any] = Field(default_factory=dict)  # stand above the tuned ones
    model: str | None = None  # path below config/; {policy} is filled in


class RobustnessEntry(_Part):
    """Which methods the testing techniques are set upon."""

    methods: list[str]
    techniques: list[str]


class CurveEntry(_Part):
    """The settings of a method among which the best at a price is looked for: every combination of the values."""

    method: str  # a key of the plan's methods
    values: list[dict[str, list[Any]]]  # grids, one after another


class QuickEntry(_Part):
    """What a quick run leaves in."""

    cases: int
    methods: list[str]
    monitors: list[str]


class WatchedEntry(_Part):
    """A monitor that is another method than its name says, or has another title."""

    method: str  # a key of the plan's methods
    title: str


class BenchmarkPlan(_Part):
    """tests/benchmarks/adreft.yaml."""

    policies: list[str]
    tuned: str
    methods: dict[str, PlannedMethod]
    monitors: list[str]
    watched: dict[str, WatchedEntry] = Field(default_factory=dict)  # by monitor
    robustness: RobustnessEntry
    ordinary: list[str]  # methods whose price is told on ordinary drives
    curves: list[CurveEntry]
    quick: QuickEntry


@dataclass(frozen=True, slots=True)
class Contender:
    """A method that can run under one policy."""

    name: str  # in the benchmark
    title: str
    group: Group
    policy: str
    method: str  # in the registry
    parameters: dict[str, Any] = field(default_factory=dict)  # what differs from the method's defaults
    model: Path | None = None
    model_digest: str = ""
    code: str = ""  # digest of the code that drives: policy, method and world
    is_tuned: bool = False  # whether the parameters were found on the validation set

    @property
    def key(self) -> str:
        """Digest of all that decides what the method does."""
        decided = {name: value for name, value in self.parameters.items() if name != "model"}
        return _digest(json.dumps([self.method, decided, self.model_digest, self.code], sort_keys=True).encode())

    def describe(self) -> dict[str, Any]:
        """As plain values, without places on this machine."""
        content: dict[str, Any] = {
            "method": self.method,
            "parameters": {name: value for name, value in self.parameters.items() if name != "model"},
            "tuned": self.is_tuned,
            "code": self.code,
        }
        if self.model is not None:
            size = self.model.stat().st_size
            content["model"] = {"file": self.model.name, "digest": self.model_digest, "bytes": size}
        return content


@dataclass(frozen=True, slots=True)
class Absence:
    """A method that cannot run under a policy, and why."""

    name: str
    policy: str
    reason: str


def read_plan(path: Path) -> BenchmarkPlan:
    """The plan of the benchmark.

    Raises:
        InputError: the file is missing or holds no plan.
    """
    plan = read_settings(path, BenchmarkPlan, "mend the file")
    monitors = [watched_method(plan, name) for name in (*plan.monitors, *plan.quick.monitors)]
    curves = [curve.method for curve in plan.curves]
    for name in [*monitors, *plan.robustness.methods, *plan.ordinary, *curves, *plan.quick.methods]:
        if name not in plan.methods:
            raise InputError(f"{path}: methods", f"there is no {name!r}", "add it or take it out of the lists")
    return plan


def resolve(plan: BenchmarkPlan, config: Path, policy: str, names: list[str]) -> tuple[list[Contender], list[Absence]]:
    """The methods that can run under a policy, and those that cannot.

    Args:
        plan: the benchmark's plan.
        config: the folder config/.
        policy: name of the policy.
        names: keys of ``plan.methods``.

    Raises:
        InputError: a parameter is unusable.
    """
    if policy not in POLICIES:
        return [], [Absence(name, policy, f"there is no policy {policy!r} in this version") for name in names]
    try:
        driver = make_policy(policy)
    except InputError as error:
        return [], [Absence(name, policy, str(error)) for name in names]
    tuned = _tuned(config / plan.tuned.format(policy=policy))
    found: list[Contender] = []
    absent: list[Absence] = []
    for name in names:
        entry = plan.methods[name]
        model = config / entry.model.format(policy=policy) if entry.model else None
        if entry.group == "bound":
            code = source_digest([type(driver).__module__, *_ALWAYS])
            found.append(Contender(name, entry.title, entry.group, policy, entry.method, code=code))
        elif entry.method not in METHODS:
            absent.append(Absence(name, policy, f"there is no repair method {entry.method!r} in this version"))
        elif model is not None and not model.is_file():
            absent.append(Absence(name, policy, f"there is no model {model.relative_to(config.parent).as_posix()}"))
        else:
            parameters = {**(tuned.get(name, {}) if entry.tuned else {}), **entry.parameters}
            digest = ""
            if model is not None:
                parameters["model"] = str(model)
                digest = _digest(model.read_bytes())
            maker = METHODS[entry.method]
            made = maker.make(check_parameters(parameters, maker.parameters, entry.method), 0)
            code = source_digest([type(driver).__module__, type(made).__module__, *_ALWAYS])
            is_tuned = entry.tuned and name in tuned
            found.append(
                Contender(
                    name, entry.title, entry.group, policy, entry.method, parameters, model, digest, code, is_tuned
                )
            )
    return found, absent


def resolve_monitors(plan: BenchmarkPlan, config: Path, policy: str, names: list[str]) -> list[Contender]:
    """The methods that can be watched as monitors under a policy, by the monitors' names and titles.

    Args:
        plan: the benchmark's plan.
        config: the folder config/.
        policy: name of the policy.
        names: of ``plan.monitors``.

    Raises:
        InputError: a parameter is unusable.
    """
    methods = {name: watched_method(plan, name) for name in names}
    found, _ = resolve(plan, config, policy, [*dict.fromkeys(methods.values())])
    contenders = {contender.name: contender for contender in found}
    monitors = []
    for name, method in methods.items():
        if method in contenders:
            title = plan.watched[name].title if name in plan.watched else None
            monitors.append(replace(contenders[method], name=name, title=title or contenders[method].title))
    return monitors


def watched_method(plan: BenchmarkPlan, name: str) -> str:
    """The method that a monitor is."""
    return plan.watched[name].method if name in plan.watched else name


def _tuned(path: Path) -> dict[str, dict[str, Any]]:
    """Parameters by the names of the benchmark's methods; none where nothing was tuned yet."""
    if not path.is_file():
        return {}
    tuned = read_settings(path, TunedMethods, "tune the rivals again")
    return {name: method.parameters for name, method in tuned.methods.items()}


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()
