"""The faults that a campaign knows, by where they come in: a node's process, a message's way, a method, a file."""

from typing import Literal, Self

from pydantic import Field, model_validator

from roadmend.core.outcome import EventKind
from roadmend.core.parameters import Parameters
from roadmend.core.repair import RepairStatus
from roadmend.faults.distortion import LINKS, STRANGERS, check_distortion

DECLARABLE = (*(status.name for status in RepairStatus), EventKind.WATCHDOG.name)
RELAY, STRANGER = "relay_node", "stranger_node"
Clock = Literal["lockstep", "realtime"]


class Fault(Parameters):
    """What all rows of the running graph have: a name, and what must come of it."""

    name: str = Field(description="as the table calls it")
    declared: str | None = Field(
        None, description=f"state of repair, or event, by which the bag must show it: {', '.join(DECLARABLE)}"
    )
    exits: tuple[int, ...] = Field((0,), description="exit codes of 'roadmend run' that are right")
    named: bool = Field(
        default=True, description="whether standard error must name it, even where there is nothing to declare"
    )
    prompt: bool = Field(default=True, description="whether it can be known with the first tick that it touches")
    clocks: tuple[Clock, ...] = Field(("lockstep", "realtime"), min_length=1, description="on which it means something")

    @model_validator(mode="after")
    def _check_declared(self) -> Self:
        if self.declared is not None and self.declared not in DECLARABLE:
            raise ValueError(f"declared: {self.declared!r} is none of {', '.join(DECLARABLE)}")
        return self

    @property
    def said(self) -> str:
        """What standard error must hold where it must name the fault."""
        return self.declared or ""

    @property
    def is_driven(self) -> bool:
        """Whether the vehicle drives at all with it, so that there is a bag."""
        return True


class SignalFault(Fault):
    """A signal to the process of one node."""

    node: Literal["sim", "policy", "repair", "recorder", "viz"] = Field(description="whose process it is sent to")
    signal: Literal["KILL", "STOP", "TERM", "INT", "SEGV"] = Field(description="without SIG")
    resume: float | None = Field(None, gt=0.0, le=600.0, description="[s] of wall time after which SIGCONT follows")

    @model_validator(mode="after")
    def _check_resume(self) -> Self:
        if self.resume is not None and self.signal != "STOP":
            raise ValueError("resume: only who was stopped can go on")
        return self

    @property
    def said(self) -> str:
        """The node's name; of one that goes on again, what it left unanswered meanwhile, if that must be declared."""
        return self.declared if self.resume is not None and self.declared else f"{self.node}_node"


class TopicFault(Fault):
    """Messages that are changed, held up or dropped on their way, by a relay that the campaign starts; or a stranger's."""

    topic: str = Field(description=f"whose messages: one of {', '.join(LINKS)}")
    distortion: str = Field(description="what is done to them, see faults/distortion.py")
    share: float = Field(1.0, gt=0.0, le=1.0, description="of the messages while it lasts")
    ticks: int = Field(20, ge=1, le=100_000, description="how long it lasts")
    late: int = Field(0, ge=0, le=1000, description="ticks by which messages are held up; of 'late'")
    shift: float = Field(0.0, ge=-60.0, le=60.0, description="[s] by which the clock jumps; of 'jump'")
    after: float = Field(0.0, ge=0.0, le=600.0, description="[s] simulated before which it does not begin")
    says: str = Field("", description="what standard error must hold; the state's name if empty")

    @model_validator(mode="after")
    def _check_distortion(self) -> Self:
        check_distortion(self.topic, self.distortion)
        if (self.distortion == "late") != (self.late > 0) or (self.distortion == "jump") != (self.shift != 0.0):
            raise ValueError("late: is of the distortion 'late', and shift of 'jump'")
        if self.named and not self.said:
            raise ValueError("named: by what words? give declared or says, or named: false")
        return self

    @property
    def said(self) -> str:
        """What was asked for, or the state."""
        return self.says or self.declared or ""

    @property
    def node(self) -> str:
        """Who distorts, as a node."""
        return STRANGER if self.is_stranger else RELAY

    @property
    def is_stranger(self) -> bool:
        """Whether nobody is distorted, but another one speaks too."""
        return self.distortion in STRANGERS


class MethodFault(Fault):
    """A repair method that cannot be used, or fails while it drives."""

    method: Literal["missing", "changed", "cut", "foreign", "raises", "not_finite", "overruns"] = Field(
        description="missing: no model file; changed: one bit of it; cut: half of it; foreign: the model of another "
        "method; raises, not_finite, overruns: what a method of the campaign's own does in place of an answer"
    )
    share: float = Field(1.0, gt=0.0, le=1.0, description="of the ticks while it lasts")
    ticks: int = Field(20, ge=1, le=100_000, description="how long it lasts")

    @property
    def said(self) -> str:
        """The model, where it cannot be used, else the state."""
        return self.declared or "model"

    @property
    def is_driven(self) -> bool:
        """Whether it is a method that can be asked."""
        return self.method in {"raises", "not_finite", "overruns"}
