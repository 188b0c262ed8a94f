"""An intervention explained: what it did, what it was worth, because of whom, why, and whether it was needed."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from roadmend.core.repair import Repair, RepairTrigger
from roadmend.core.scene import EgoState, ObjectList
from roadmend.core.spell import Spell, SpellBuilder
from roadmend.core.tick import INTERVAL
from roadmend.core.trigger_sight import TriggerSight, sight_of

MINOR = 0.1  # share of the greatest weight


@dataclass(frozen=True, slots=True)
class SpellAccount:
    """A spell and its reasons. Worth, who and why are those of its first tick, as its need is."""

    spell: Spell
    strongest: float  # least throttle - brake that was sent, -1 .. 1
    worth: float | None  # see ``Repair.worth``
    who: tuple[TriggerSight, ...]  # the weightiest first
    why: str  # one line for people

    @property
    def chiefly(self) -> tuple[TriggerSight, ...]:
        """Of those that made the method step in, the ones that matter: the others have less than MINOR of the first's weight."""
        return tuple(sight for sight in self.who if sight.weight >= MINOR * self.who[0].weight or sight is self.who[0])

    def as_dict(self) -> dict[str, Any]:
        """Plain values, for JSON; times [s]."""
        return {
            "begin": self.spell.begin,
            "ticks": self.spell.ticks,
            "duration": self.spell.end - self.spell.begin,
            "dose": self.spell.dose,
            "strongest": self.strongest,
            "worth": self.worth,
            "need": self.spell.need,
            "triggers": [sight.as_dict() for sight in self.who],
            "reason": self.why,
        }


def with_needs(accounts: Iterable[SpellAccount], spells: Iterable[Spell]) -> tuple[SpellAccount, ...]:
    """The accounts with the needs of those ``spells`` that begin at the same tick."""
    needs = {round(spell.begin / INTERVAL): spell.need for spell in spells}
    return tuple(
        replace(account, spell=replace(account.spell, need=needs.get(round(account.spell.begin / INTERVAL))))
        for account in accounts
    )


class SpellAccountBuilder:
    """Takes in answer by answer and gives an account of every spell."""

    def __init__(self) -> None:
        self._spells = SpellBuilder()
        self._accounts: list[SpellAccount] = []  # all but their spells
        self._triggers: Sequence[RepairTrigger] = ()  # of the last account

    def add(self, time: float, repair: Repair) -> bool:
        """Take in the answer at ``time`` [s]; returns whether a spell begins with it, of which ``see`` can tell more."""
        begins = self._spells.add(time, repair)
        if begins:
            self._triggers = repair.triggers
            who = tuple(TriggerSight(trigger.object_id, trigger.weight) for trigger in repair.triggers)
            spell = self._spells.spells[-1]
            self._accounts.append(SpellAccount(spell, repair.final_action, repair.worth, who, repair.reason))
        elif repair.intervened:
            last = self._accounts[-1]
            self._accounts[-1] = replace(last, strongest=min(last.strongest, repair.final_action))
        return begins

    def see(self, ego: EgoState, objects: ObjectList) -> None:
        """Tell what there was to see at the first tick of the last spell."""
        who = tuple(sight_of(trigger, ego, objects) for trigger in self._triggers)
        self._accounts[-1] = replace(self._accounts[-1], who=who)

    @property
    def accounts(self) -> tuple[SpellAccount, ...]:
        """Those so far, the last perhaps of a spell that is unfinished."""
        return tuple(
            replace(account, spell=spell) for account, spell in zip(self._accounts, self._spells.spells, strict=True)
        )
