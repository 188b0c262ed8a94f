"""What was repaired, and its spells, in a file that is read from front to back, whole or not, in little memory."""

import contextlib
from dataclasses import dataclass, field
from typing import Any

from roadmend.core.repair import Repair
from roadmend.core.route import Route
from roadmend.core.spell_account import SpellAccount, SpellAccountBuilder
from roadmend.recording import messages
from roadmend.recording.codec import Codec
from roadmend.recording.scan import ScannedMessage
from roadmend.recording.ticks import LATE_NS
from roadmend.recording.topics import EGO, EVENTS, OBJECTS, REPAIR_STATE, ROUTE, TYPES, own

_TOPICS = (EGO, OBJECTS, ROUTE, EVENTS, REPAIR_STATE)


@dataclass(slots=True)
class InterventionSummary:
    """What the repair node did, tick by tick."""

    ticks: int = 0
    interventions: int = 0  # ticks at which the command was changed
    spells: int = 0  # uninterrupted runs of these
    states: dict[str, int] = field(default_factory=dict)  # ticks by state
    _last: bool = False

    def add(self, repair: Repair) -> None:
        """Count one tick."""
        self.ticks += 1
        self.interventions += repair.intervened
        self.spells += repair.intervened and not self._last
        self._last = repair.intervened
        self.states[repair.status.name] = self.states.get(repair.status.name, 0) + 1


class SpellScan:
    """Takes in message by message. What was seen is decoded only for the first tick of a spell.

    Args:
        codec: for the messages of the file, by the definitions that it carries.
    """

    def __init__(self, codec: Codec) -> None:
        self._codec = codec
        self._graphs: dict[str, _Graph] = {}  # by namespace, with the "/" at its end

    def take(self, item: ScannedMessage, value: Any = None) -> None:
        """Take in one message; ``value`` is what it says, where it has been decoded already.

        Raises:
            ValueError: it was altered on the disk.
        """
        kind, name = item.topic.definition.type_name, item.topic.name
        topic = next((one for one in _TOPICS if TYPES[one] == kind and name.endswith(f"/{one}")), None)
        if topic is None and kind == TYPES[REPAIR_STATE]:  # under another name, of which no scene is known
            name, topic = f"{name}/{REPAIR_STATE}", REPAIR_STATE
        if topic is not None:
            self._graphs.setdefault(name.removesuffix(topic), _Graph(self._codec)).take(topic, item, value)

    def accounts(self) -> tuple[SpellAccount, ...]:
        """Of the whole file; as ``BagTicks`` does, of the graph in the shortest namespace."""
        graph = self._own()
        return () if graph is None else graph.builder.accounts

    def summary(self) -> InterventionSummary | None:
        """Likewise what was done; None where nobody told."""
        graph = self._own()
        return None if graph is None else graph.summary

    def _own(self) -> "_Graph | None":
        graphs = {name: graph for name, graph in self._graphs.items() if graph.answers}
        name = own(graphs)
        if name is None:
            return None
        graphs[name].close()
        return graphs[name]


@dataclass(slots=True)
class _Parts:
    """What there is of one tick."""

    ego: ScannedMessage | None = None
    objects: ScannedMessage | None = None
    repair: Repair | None = None
    is_final: bool = False


@dataclass(slots=True)
class _Graph:
    """The ticks of one graph, those of the last second still open for what comes late."""

    codec: Codec
    answers: int = 0
    builder: SpellAccountBuilder = field(default_factory=SpellAccountBuilder)
    summary: InterventionSummary = field(default_factory=InterventionSummary)
    _route: Route | None = None
    _open: dict[int, _Parts] = field(default_factory=dict)  # by stamp [ns]

    def take(self, topic: str, item: ScannedMessage, value: Any) -> None:
        stamp = messages.stamp_of_bytes(item.data)
        if topic == ROUTE:
            self._route = messages.route_of(self._decoded(item))
            return
        if stamp not in self._open:
            for done in sorted(known for known in self._open if known < stamp - LATE_NS):
                self._close(done)
            self._open[stamp] = _Parts()
        parts = self._open[stamp]
        if topic == EGO:
            parts.ego = item
        elif topic == OBJECTS:
            parts.objects = item
        elif topic == EVENTS:
            event = messages.event_of(value)
            parts.is_final |= event is not None and event.kind.is_final
        else:
            parts.repair = messages.repair_of(value)
            self.answers += 1

    def close(self) -> None:
        for stamp in sorted(self._open):
            self._close(stamp)

    def _close(self, stamp: int) -> None:
        parts = self._open.pop(stamp)
        if parts.repair is None or parts.is_final:  # nobody drives on the answer to the final tick
            return
        self.summary.add(parts.repair)
        begins = self.builder.add(stamp * 1e-9, parts.repair)
        if begins and parts.ego is not None and parts.objects is not None:
            with contextlib.suppress(ValueError):  # altered on the disk: it is not known then who it was about
                ego = messages.ego_of(self._decoded(parts.ego))
                objects, _ = messages.objects_of(self._decoded(parts.objects))
                self.builder.see(ego if self._route is None else messages.sized(ego, self._route), objects)

    def _decoded(self, item: ScannedMessage) -> Any:
        return self.codec.decode(item.topic.definition, item.data)
