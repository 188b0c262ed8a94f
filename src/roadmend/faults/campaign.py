"""A campaign: which faults are put into the graph, how often, and what each must lead to."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from roadmend.core.outcome import EventKind
from roadmend.core.parameters import Parameters
from roadmend.core.repair import RepairStatus
from roadmend.core.settings import read_settings

BARE = "no fault"  # the row that all others are held against

DECLARABLE = (RepairStatus.STALE_COMMAND.name, RepairStatus.STALE_OBJECTS.name, EventKind.WATCHDOG.name)


class Fault(Parameters):
    """A signal to the process of one node, and what must come of it."""

    name: str = Field(description="as the table calls it")
    node: Literal["sim", "policy", "repair", "recorder", "viz"] = Field(description="whose process it is sent to")
    signal: Literal["KILL", "STOP", "TERM", "INT", "SEGV"] = Field(description="without SIG")
    resume: float | None = Field(None, gt=0.0, le=600.0, description="[s] of wall time after which SIGCONT follows")
    declared: str | None = Field(
        None, description=f"state of repair, or event, by which the bag must show it: {', '.join(DECLARABLE)}"
    )
    exits: tuple[int, ...] = Field((0,), description="exit codes of 'roadmend run' that are right")
    named: bool = Field(default=True, description="whether standard error must name the node")

    @model_validator(mode="after")
    def _check(self) -> Self:
        if self.declared is not None and self.declared not in DECLARABLE:
            raise ValueError(f"declared: {self.declared!r} is none of {', '.join(DECLARABLE)}")
        if self.resume is not None and self.signal != "STOP":
            raise ValueError("resume: only who was stopped can go on")
        return self


class FaultCampaign(Parameters):
    """Faults times clocks times rates times seeds."""

    faults: tuple[Fault, ...] = Field(min_length=1, description="a row of the table each")
    policy: str = Field("modular", description="who drives")
    repair: str = Field("rss", description="who repairs")
    families: tuple[str, ...] = Field(("S3", "S5"), min_length=1, description="families of scenarios, by turns")
    first_scenario: int = Field(0, ge=0, description="seed of the first scenario")
    seeds: int = Field(3, ge=1, le=1000, description="runs of every row at every clock and rate")
    clocks: tuple[Literal["lockstep", "realtime"], ...] = Field(("lockstep", "realtime"), min_length=1)
    rates: tuple[float, ...] = Field((1.0,), min_length=1, description="of the real-time clock")
    earliest: float = Field(1.0, ge=0.0, description="[s] simulated: a fault comes at least this long after the start")
    latest: float = Field(4.0, gt=0.0, description="[s] simulated: and at most this long")
    patience: float = Field(120.0, gt=0.0, description="[s] of wall time after which a run counts as hung")

    @model_validator(mode="after")
    def _check(self) -> Self:
        names = [fault.name for fault in self.faults]
        if len({*names, BARE}) <= len(names):
            raise ValueError(f"faults: two of one name, or one named {BARE!r}")
        if self.latest < self.earliest:
            raise ValueError(f"latest: before the earliest, {self.earliest:g} s")
        return self


@dataclass(frozen=True)
class FaultTrial:
    """One run of a campaign."""

    fault: Fault | None  # None: undisturbed
    clock: str
    rate: float
    seed: int

    @property
    def row(self) -> str:
        """The row of the table that it belongs to."""
        return self.fault.name if self.fault else BARE

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return vars(self) | {"fault": self.fault.model_dump(mode="json") if self.fault else None}


def load_campaign(path: Path) -> FaultCampaign:
    """A campaign from its YAML file.

    Raises:
        InputError: the file cannot be read, or says what no campaign can.
    """
    return read_settings(path, FaultCampaign, "see config/faults")


def trials_of(campaign: FaultCampaign) -> Iterator[FaultTrial]:
    """All runs: undisturbed ones first, on the clocks and at the rates of the others."""
    for fault in (None, *campaign.faults):
        for clock in campaign.clocks:
            for rate in campaign.rates if clock == "realtime" else (1.0,):
                for seed in range(campaign.seeds):
                    yield FaultTrial(fault, clock, rate, seed)
