"""Counts what a repairer did over a run, however often its node had to be restarted."""

import os
import struct
from collections import Counter
from dataclasses import asdict
from pathlib import Path

from roadmend.core.command import Command
from roadmend.core.repair import Interventions, Repair, RepairStatus
from roadmend.core.spell import Spell, SpellBuilder

STALE = frozenset({RepairStatus.STALE_COMMAND, RepairStatus.STALE_OBJECTS})
_ANSWER = struct.Struct("<dddBBB")  # time [s], action asked for, action sent, state, whether they differ, held back
_RESTART = 255  # in place of a state: a new node goes on from here


class RepairTally:
    """Answers by state, and the interventions among them.

    With a journal each answer is in the file before the next one comes: a node that is killed takes nothing with it,
    and the one that takes its place goes on counting.
    """

    def __init__(self, journal: Path | None = None) -> None:
        """Begin, or go on.

        Args:
            journal: the file; it is read if it is there.
        """
        self.stale = 0  # answers without the policy's command or without a scene, of late and without a break
        self._states: Counter[RepairStatus] = Counter()
        self._interventions = Interventions()
        self._ended: tuple[Spell, ...] = ()  # those of nodes that have gone
        self._spells = SpellBuilder()
        self._descriptor = -1
        if journal is None:
            return
        try:
            data = journal.read_bytes() if journal.exists() else b""
            whole = len(data) // _ANSWER.size * _ANSWER.size
            for time, asked, sent, state, *told in _ANSWER.iter_unpack(data[:whole]):
                if state == _RESTART:
                    self._break()
                else:
                    intervened, held_back = map(bool, told)
                    self._count(time, _repair_of(asked, sent, state, intervened=intervened, held_back=held_back))
            self._break()
            self._descriptor = os.open(journal, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o644)
            os.truncate(self._descriptor, whole)  # the node may have died over an answer
            self._write(_ANSWER.pack(0.0, 0.0, 0.0, _RESTART, 0, 0))
        except (OSError, ValueError):  # without it the count is this node's alone; that is no reason to stop answering
            self.close()

    def add(self, time: float, repair: Repair) -> None:
        """Count the answer at ``time`` [s]."""
        self._count(time, repair)
        if self._descriptor < 0:
            return
        told = int(repair.status), int(repair.intervened), int(repair.held_back)
        self._write(_ANSWER.pack(time, repair.policy_action, repair.final_action, *told))

    def _write(self, record: bytes) -> None:
        try:
            if os.write(self._descriptor, record) == len(record):
                return
        except OSError:  # a full disk; see above
            pass
        self.close()

    def _break(self) -> None:
        """No spell goes on over a node's death."""
        self._ended, self._spells = (*self._ended, *self._spells.spells), SpellBuilder()

    def _count(self, time: float, repair: Repair) -> None:
        self._states[repair.status] += 1
        self._interventions.add(repair)
        self._spells.add(time, repair)
        self.stale = self.stale + 1 if repair.status in STALE else 0

    def values(self) -> dict[str, object]:
        """The counts as plain values."""
        return {
            "answers": sum(self._states.values()),
            "interventions": self._interventions.ticks,
            "change": self._interventions.change,
            "intensity": self._interventions.intensity,
            "dose": self._interventions.dose,
            **{f"state.{state.name}": count for state, count in sorted(self._states.items())},
        }

    def account(self) -> dict[str, object]:
        """The counts and the spells, as plain values."""
        spells = [*self._ended, *self._spells.spells]
        return {**self.values(), "stale": self.stale, "spells": [asdict(spell) for spell in spells]}

    def close(self) -> None:
        """Write no more. Does nothing the second time."""
        if self._descriptor >= 0:
            os.close(self._descriptor)
            self._descriptor = -1


def _repair_of(asked: float, sent: float, state: int, *, intervened: bool, held_back: bool) -> Repair:
    """An answer as far as it counts."""
    status = RepairStatus(state)
    command = Command.from_action(sent)
    return Repair(command, status, 0.0, 0.0, asked, sent, intervened=intervened, held_back=held_back)
