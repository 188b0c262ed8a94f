"""What a bag shows of a fault: who fell silent when, what was declared and when, what is missing."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from roadmend.core.outcome import EventKind
from roadmend.core.repair import RepairStatus
from roadmend.core.tick import INTERVAL
from roadmend.recording import topics
from roadmend.recording.reader import BagReader
from roadmend.recording.ticks import BagTick, BagTicks

_NS = 1e-9
_OF_WATCHDOG = frozenset({EventKind.WATCHDOG, EventKind.RECOVERED})
_MEANWHILE = 40  # ticks of which the states are kept
_LESSER = frozenset(  # than a stop for want of a message, which a tick shows in their place
    status.name for status in (RepairStatus.INVALID_COMMAND, RepairStatus.INVALID_OBJECTS, RepairStatus.MODEL_FAULT)
)
_STOPS = frozenset({RepairStatus.STALE_COMMAND, RepairStatus.STALE_OBJECTS})


@dataclass(frozen=True)
class Evidence:
    """What came of a fault, as recorded.

    Attributes:
        ticks: in the bag.
        is_declared: whether the state or event that was asked for stands anywhere behind the first answer. Who was away
            for a while may have answered each tick in the end, late.
        lost: messages of the simulator that are not in it although it drove on, one ego and one object list a tick.
        silence: simulated time of the first tick that the node did not answer, or whose messages were distorted [s]; None
            if it answered all, or need not.
        to_state: simulated time from there until the state or event was declared [s]; None if it never was. Of a state that
            says what a message held, or what the method did, from the first disturbed tick whose messages were all there: a
            stop for want of one is graver.
        to_standstill: likewise until the ego stood.
        in_diagnostics: whether the repair node or the simulator has warned there after the drive had begun.
        begun: simulated time of the first tick that was driven by the policy's command [s]; None without one. Before it the
            vehicle is held, and the policy may answer those ticks later.
        meanwhile: states of repair at the ticks from where ``to_state`` counts until the state was declared, at most 40,
            a dash where a tick has none; empty where it was declared at once.
    """

    ticks: int
    lost: int
    is_declared: bool = False
    silence: float | None = None
    to_state: float | None = None
    to_standstill: float | None = None
    in_diagnostics: bool = False
    begun: float | None = None
    meanwhile: tuple[str, ...] = ()

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON."""
        return asdict(self) | {"meanwhile": list(self.meanwhile)}

    @classmethod
    def parse(cls, entry: Mapping[str, Any]) -> "Evidence":
        """From ``as_dict``."""
        return cls(**{**entry, "meanwhile": tuple(entry["meanwhile"])})


def read_evidence(
    path: Path, node: str | None, declared: str | None, duration: float | None, touched: Sequence[int] | None = None
) -> Evidence:
    """What a bag shows; see :func:`evidence_of`.

    Raises:
        InputError: there is no such bag, it is corrupt, or holds no episode.
    """
    reader = BagReader(path)
    found = evidence_of(BagTicks(reader), node, declared, duration, touched)
    return replace(found, in_diagnostics=found.begun is not None and _has_warned(reader, found.begun))


def _has_warned(reader: BagReader, begun: float) -> bool:
    """Whether the repair node or the simulator has warned since the vehicle was driven, at ``begun`` [s]."""
    for message in reader.messages([topics.DIAGNOSTICS]):
        if message.time_ns * _NS < begun:
            continue
        for status in message.value.status:
            is_asked = status.name.endswith(("/repair_node", "/sim_node"))
            if is_asked and status.level and not status.message.startswith(("inactive", "waiting")):
                return True
    return False


def evidence_of(
    bag: Iterable[BagTick],
    node: str | None,
    declared: str | None,
    duration: float | None,
    touched: Sequence[int] | None = None,
) -> Evidence:
    """What a bag shows.

    Args:
        bag: its ticks, in the order of their stamps.
        node: who was disturbed, without "_node"; None for nobody.
        declared: the state of repair, or the event, that must be in it; None for none.
        duration: of the episode as the result tells it [s]; None where there is no result.
        touched: stamps [ns], in order, of the ticks whose messages were distorted so that it must be declared, or at which the
            method failed; None where it was neither, and silence tells the moment.
    """
    ticks = [tick for tick in bag if tick.ego is not None or tick.driven or tick.command or tick.events]
    seen = [tick for tick in ticks if tick.ego is not None]
    span = 0.0 if len(seen) < 2 else (seen[-1].stamp - seen[0].stamp) * _NS
    expected = round(max(span, (duration or 0.0)) / INTERVAL) + 1
    lost = 2 * expected - len(seen) - sum(tick.objects is not None for tick in seen)
    silence = _first_silent(seen, node) if touched is None else next(iter(touched), None)
    begun = next((tick.stamp for tick in seen if _is_driven(tick)), None)
    is_declared = declared is not None and any(
        begun is not None and tick.stamp > begun and _declares(tick, declared) for tick in ticks
    )
    found = Evidence(
        len(seen),
        max(0, lost),
        is_declared,
        None if silence is None else silence * _NS,
        begun=None if begun is None else begun * _NS,
    )
    if silence is None or declared is None:
        return found
    disturbed = [tick for tick in ticks if tick.stamp >= silence]
    begun_at = silence
    if declared in _LESSER and touched is not None:
        whole = {tick.stamp for tick in disturbed if not _is_stopped(tick)}
        begun_at = next((stamp for stamp in touched if stamp in whole), silence)
    shown = next((tick.stamp for tick in disturbed if tick.stamp >= begun_at and _declares(tick, declared)), None)
    if declared == EventKind.WATCHDOG.name and _brakes_already(ticks, begun_at):
        shown = begun_at  # it is said once, when it begins
    until = shown if shown is not None else disturbed[-1].stamp + 1 if disturbed else begun_at
    waited = [tick.repair.status.name if tick.repair else "-" for tick in disturbed if begun_at <= tick.stamp < until]
    stood = next((tick.stamp for tick in disturbed if tick.ego is not None and tick.ego.speed < 0.1), None)
    return replace(
        found,
        to_state=None if shown is None else (shown - begun_at) * _NS,
        to_standstill=None if stood is None else (stood - silence) * _NS,
        meanwhile=tuple(waited[:_MEANWHILE]),
    )


def _brakes_already(ticks: Sequence[BagTick], stamp: int) -> bool:
    """Whether the simulator's watchdog braked when this tick [ns] came, for another reason."""
    said = [event.kind for tick in ticks if tick.stamp < stamp for event in tick.events]
    return next((kind is EventKind.WATCHDOG for kind in reversed(said) if kind in _OF_WATCHDOG), False)


def _is_stopped(tick: BagTick) -> bool:
    """Whether the repair node had to do without a part of it, or passed it over for a newer one."""
    return tick.repair is None or tick.repair.status in _STOPS


def _is_driven(tick: BagTick) -> bool:
    is_held = tick.repair is not None and tick.repair.status is RepairStatus.STARTING
    return tick.command is not None and tick.driven is not None and not is_held


def _first_silent(ticks: Sequence[BagTick], node: str | None) -> int | None:
    """Stamp of the first tick of the longest silence of a node after its first answer [ns].

    On a busy machine single ticks go unanswered without any fault, hence the longest. A tick that is the last of all
    need not be answered.
    """
    if node not in {"policy", "repair"}:
        return None
    answers = [tick.command if node == "policy" else tick.driven for tick in ticks[:-1]]
    first = next((place for place, answer in enumerate(answers) if answer is not None), len(answers))
    longest, begin, length = 0, None, 0
    for place in range(first, len(answers)):
        length = 0 if answers[place] is not None else length + 1
        if length > longest:
            longest, begin = length, place - length + 1
    return None if begin is None else ticks[begin].stamp


def _declares(tick: BagTick, name: str) -> bool:
    if tick.repair is not None and tick.repair.status.name == name:
        return True
    return any(event.kind.name == name for event in tick.events)
