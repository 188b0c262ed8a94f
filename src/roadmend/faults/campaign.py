"""A campaign: which faults are put into the graph, how often, and what each must lead to."""

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import Field, model_validator

from roadmend.core.parameters import Parameters
from roadmend.core.settings import read_settings
from roadmend.faults.fault import Clock, Fault, MethodFault, SignalFault, TopicFault
from roadmend.faults.files import FileCampaign

BARE = "no fault"  # the row that all others are held against
RATE_MIN, RATE_MAX = 0.01, 100.0  # of real time
Rate = Annotated[float, Field(ge=RATE_MIN, le=RATE_MAX)]
FILES = "files"  # what all rows of files are called where rows are chosen


class FaultCampaign(Parameters):
    """Faults times clocks times rates times seeds."""

    signals: tuple[SignalFault, ...] = Field((), description="rows of the table: processes")
    topics: tuple[TopicFault, ...] = Field((), description="rows of the table: messages on their way")
    methods: tuple[MethodFault, ...] = Field((), description="rows of the table: repair methods")
    files: FileCampaign | None = Field(None, description="damaged files, given to every command that reads one")
    policy: str = Field("modular", description="who drives")
    repair: str = Field("rss", description="who repairs")
    families: tuple[str, ...] = Field(("S3", "S5"), min_length=1, description="families of scenarios, by turns")
    first_scenario: int = Field(0, ge=0, description="seed of the first scenario")
    seeds: int = Field(3, ge=1, le=1000, description="runs of every row at every clock and rate")
    clocks: tuple[Clock, ...] = Field(("lockstep", "realtime"), min_length=1)
    rates: tuple[Rate, ...] = Field((1.0,), min_length=1, description="of the real-time clock")
    one_rate: bool = Field(default=False, description="each row at one of the rates, by its name, not at all of them")
    earliest: float = Field(1.0, ge=0.0, description="[s] simulated: a fault comes at least this long after the start")
    latest: float = Field(4.0, gt=0.0, description="[s] simulated: and at most this long")
    time_limit: float | None = Field(None, gt=0.0, description="[s] simulated, of every scenario; its own if None")
    patience: float = Field(120.0, gt=0.0, description="[s] of wall time after which a run counts as hung")

    @model_validator(mode="after")
    def _check(self) -> Self:
        names = [fault.name for fault in self.faults]
        if not names and self.files is None:
            raise ValueError("signals, topics, methods, files: at least 1 row")
        if len({*names, BARE, FILES}) < len(names) + 2:
            raise ValueError(f"faults: two of one name, or one named {BARE!r} or {FILES!r}")
        if self.latest < self.earliest:
            raise ValueError(f"latest: before the earliest, {self.earliest:g} s")
        return self

    @property
    def faults(self) -> tuple[Fault, ...]:
        """All rows."""
        return (*self.signals, *self.topics, *self.methods)

    def only(self, names: Collection[str]) -> Self:
        """The same with these rows alone; FILES names all of the files."""
        rows: dict[str, Any] = {
            kind: tuple(fault for fault in getattr(self, kind) if fault.name in names)
            for kind in ("signals", "topics", "methods")
        }
        return self.model_copy(update=rows | {"files": self.files if FILES in names else None})


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
    """All runs: of each seed the undisturbed ones first, on the clocks and at the rates of the others.

    Seed by seed, so that of a campaign that is not finished every row has runs.
    """
    for seed in range(campaign.seeds):
        for fault in (None, *campaign.faults) if campaign.faults else ():
            rates = campaign.rates
            if campaign.one_rate and fault is not None:
                # By its name, so that a row has the same one when it is run alone.
                rates = (campaign.rates[sum(fault.name.encode()) % len(campaign.rates)],)
            for clock in campaign.clocks:
                if fault is not None and clock not in fault.clocks:
                    continue
                for rate in rates if clock == "realtime" else (1.0,):
                    yield FaultTrial(fault, clock, rate, seed)
