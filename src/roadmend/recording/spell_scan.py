"""Accounts of the spells in a file that is read from front to back, whole or not, in little memory."""

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
        if topic is not None:
            self._graphs.setdefault(name.removesuffix(topic), _Graph(self._codec)).take(topic, item, value)

    def accounts(self) -> tuple[SpellAccount, ...]:
        """Of the whole file; as ``BagTicks`` does, of the graph in the shortest namespace."""
        graphs = {name: graph for name, graph in self._graphs.items() if graph.answers}
        name = own(graphs)
        return () if name is None else graphs[name].accounts()


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
    _route: Route | None = None
    _open: dict[int, _Parts] = field(default_factory=dict)  # by stamp [ns]
    _builder: SpellAccountBuilder = field(default_factory=SpellAccountBuilder)

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

    def accounts(self) -> tuple[SpellAccount, ...]:
        for stamp in sorted(self._open):
            self._close(stamp)
        return self._builder.accounts

    def _close(self, stamp: int) -> None:
        parts = self._open.pop(stamp)
        if parts.repair is None or parts.is_final:  # nobody drives on the answer to the final tick
            return
        begins = self._builder.add(stamp * 1e-9, parts.repair)
        if begins and parts.ego is not None and parts.objects is not None:
            with contextlib.suppress(ValueError):  # altered on the disk: it is not known then who it was about
                ego = messages.ego_of(self._decoded(parts.ego))
                objects, _ = messages.objects_of(self._decoded(parts.objects))
                self._builder.see(ego if self._route is None else messages.sized(ego, self._route), objects)

    def _decoded(self, item: ScannedMessage) -> Any:
        return self.codec.decode(item.topic.definition, item.data)
