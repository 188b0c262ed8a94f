"""Who does what a verb says, where its subject stands before it, behind it, or in the clause before."""

from dataclasses import replace

from roadmend.safe.reading.clauses import NOBODY, STRIKES, Actor, Clause
from roadmend.safe.reading.lexicon import VerbSense, word_set
from roadmend.safe.reading.referents import Referents, is_apart
from roadmend.safe.reading.tokens import Item, Words

_GOVERNING = frozenset({"intend", "begin", "avoid", "fail", "see", "say", "do", "stop", "slow", "park"})
_STRICT = frozenset({"intend", "begin", "fail"})  # govern only with "to"


class Subjects(Referents):
    """Tells the subject of a verb."""

    head: list[Item]  # words that wait for their verb
    of_head: list[tuple[Item, Actor]]

    def _after(self, place: int, verb: VerbSense) -> tuple[Actor, frozenset[str]] | None:
        """Who stands behind the verb: "from the ramp came a van", "behind it was a bus"."""
        mention = self.starts.get(place + 1)
        comes = verb.kind in {"travel", "emerge", "stop", "follow", "approach"} and verb.lemma not in {
            "drive",
            "operate",
        }
        opens = self.items.cut(0, 2).has("preposition", "behind") and (
            self.clause is None or verb.form in {"past", "s"}
        )
        told = self.pending is None or (bool(self.clauses) and self.clauses[-1].subject.span == self.pending.span)
        if not told or mention is None or not comes or not opens:
            return None
        actor = self._resolve(mention)
        return (actor, frozenset()) if actor.vehicles else None

    def _subject(self, place: int, verb: VerbSense) -> tuple[Actor, frozenset[str]]:
        """Who does it, and the kinds of the verbs that it depends on."""
        old, nothing = self.clause, frozenset[str]()
        is_owner = self.pending is not None and self.pending.part is not None
        if is_owner and verb.form == "ing" and self._follows(place) and self.last.vehicles:
            return self.last, nothing  # "its left side met a truck pulling a trailer"
        if self.pending is self.road and self.road is not None and any(item.low == "," for item in self.head):
            return self.focus, nothing  # what a road does is over
        if self.pending is not None:
            return self.pending, nothing
        if old is None and verb.form == "ing" and self._follows(place) and self.last.vehicles:
            return self.last, nothing  # "some kid in a Civic coming south"
        is_own = (
            self.writer
            and place == 0
            and verb.kind in {*STRIKES, "stop", "slow"}
            and self.items.at(1).low not in {"me", "us"}
        )
        if old is None and is_own and verb.form in {"past", "both"}:
            return replace(NOBODY, vehicles=self.writer, is_person=True), nothing  # "Hit him in the door"
        if old is None:
            return (NOBODY if self._is_of_thing() else self.focus), nothing
        if self._is_reduced(place, verb, old):
            return self.last, nothing
        if old.kind == "see" and old.object is not None and verb.form == "ing" and self.items[place - 1].low == ",":
            return old.object, nothing  # "I saw a van, coming from the west"
        if (
            old.kind in {"see", "say"}
            and old.object is not None
            and self.items[place - 1].is_a("auxiliary", "negation")
        ):
            return old.object, nothing  # "he saw that the car was stopped"
        if old.subject is self.road and is_apart(old.tail, ",") and self.focus.vehicles:
            return self.focus, nothing  # what a road does is over
        if not self._governs(old, self.items[place]):
            return old.subject, nothing
        governed = old.governed | {old.kind}
        if old.is_denied and old.kind in {"intend", "begin", "do"}:
            governed |= {"avoid"}
        if old.kind == "avoid" and (old.is_denied or "fail" in old.governed):
            governed -= {"avoid"}  # "could not avoid striking"
        return old.subject, governed

    def _is_of_thing(self) -> bool:
        """Whether the words before a verb name something that is no vehicle: "The storm was", "Lodge Road begins"."""
        head = Words(self.head)
        if any(actor.vehicles for _, actor in self.of_head):
            return False
        article = head.at(0).get("determiner") in {"a", "the"} and not head.at(1).is_a("hand", "bound", "lane", "part")
        named = (head.at(0).is_name and not head.at(0).kinds) or (
            head.at(0).is_name and head.cut(1, 3).at(0).is_a("road")
        )
        return article or (named and head.cut(1, 3).has("road", "auxiliary"))

    def _governs(self, old: Clause, item: Item) -> bool:
        """Whether a verb depends on the one before it: "attempted to turn", "was stopped waiting to turn"."""
        if old.kind not in _GOVERNING or is_apart(old.tail, ",;"):
            return False
        loose = old.kind in _STRICT and any(each.kinds and each.low != "to" for each in old.tail)
        return not loose and not any(actor.span.end > item.span.start for _, actor in old.others)

    def _is_reduced(self, place: int, verb: VerbSense, old: Clause) -> bool:
        """Whether the verb says something of the noun group before it: "struck V2 parked at the curb"."""
        while place > 1 and self.items[place - 1].low in word_set("reduced_fillers"):
            place -= 1
        is_subject = old.subject.span == self.last.span
        is_pronoun = self.items.at(place - 1).is_a("pronoun")
        told_on = old.verb is not None and old.verb.form == "ing" and (is_pronoun or not old.head.has("auxiliary"))
        if (
            told_on
            and verb.form == "both"
            and old.subject.vehicles
            and old.object is not None
            and old.object.span == self.last.span
        ):
            return False  # "the man facing me started"
        return self._follows(place) and not is_subject and verb.form in {"ing", "both", "participle"}
