"""Parameters of repair_node, and the times that follow from them."""

from dataclasses import dataclass
from typing import Literal, Self

from pydantic import Field

from roadmend.core.command_age import CommandAge
from roadmend.core.parameters import Parameters
from roadmend.recording.foreign_parameters import PATIENCE_MAX_S, PATIENCE_S
from roadmend.repair.registry import METHOD_REGISTRY

REALTIME_BUDGET_S = 0.03  # [s] for a method's tick


class RepairNodeParameters(Parameters):
    """Parameters of the node, read once at start; those of the methods can be changed while it runs."""

    method: str = Field("rss", description=f"repair method to run: one of {METHOD_REGISTRY.ways}")
    policy: str = Field(
        "", description="policy whose models and tuned settings are this method's defaults; the plain defaults if empty"
    )
    writer: str = Field(
        "",
        description="name of the node whose commands are obeyed, without its namespace; whoever is there alone first "
        "if empty; of inputs: paired",
    )
    trajectory: Literal["required", "optional"] = Field(
        "required",
        description="whether a tick waits for the planned trajectory, or does without while nobody publishes any",
    )
    inputs: Literal["paired", "newest"] = Field(
        "paired",
        description="paired: the messages of a tick share one stamp, as the simulator's do; newest: they come from "
        "another stack, at rates and with stamps of their own, and the newest of each counts",
    )
    clock: Literal["lockstep", "realtime"] = Field("lockstep", description="how the simulator keeps time")
    rate: float = Field(
        1.0, ge=0.01, le=100.0, description="real time: simulated seconds per wall second, the same as the simulator's"
    )
    seed: int = Field(0, ge=0, le=2**31 - 1, description="seed of methods that draw numbers")
    input_timeout: float = Field(
        0.0,
        ge=0.0,
        le=PATIENCE_MAX_S,
        description="[s] of wall time after which an input counts as late; 0: 2.0 in lockstep, 0.3 where the newest "
        "inputs count, in real time 0.04 or 0.8 ticks, the longer; in real time never longer than 2 ticks",
    )
    time_budget: float = Field(
        0.0,
        ge=0.0,
        le=10.0,
        description="[s] a method may take for a tick before the guard decides; 0: no limit in lockstep, "
        "0.03 in real time",
    )
    autostart: bool = Field(default=True, description="configure and activate without being asked")
    summary: str = Field("", description="file for the tally of this run, written at the end; none if empty")
    journal: str = Field(
        "",
        description="file in which each answer is counted when it is given, and which a node that is started anew "
        "carries on; none if empty",
    )


@dataclass(frozen=True, slots=True)
class Times:
    """How the node keeps time.

    Attributes:
        is_lockstep: whether the simulator waits for each answer.
        timeout: wall time after which an input counts as late, where the newest inputs count [s].
        ages: how old an unanswered tick may become, where the inputs of a tick are paired.
        budget: that a method may take for a tick [s]; None without a limit.
    """

    is_lockstep: bool
    timeout: float
    ages: CommandAge
    budget: float | None

    @classmethod
    def of(cls, settings: RepairNodeParameters) -> Self:
        """Those of a node with these parameters."""
        is_newest = settings.inputs == "newest"
        is_lockstep = settings.clock == "lockstep" and not is_newest
        ages = CommandAge(is_lockstep, settings.rate, settings.input_timeout)
        budget = settings.time_budget or (None if is_lockstep else REALTIME_BUDGET_S)
        return cls(is_lockstep, settings.input_timeout or PATIENCE_S, ages, budget)
