"""Sentences taken apart into clauses.

A shallow parser: noun groups are the mentions of vehicles and of their parts, verb groups come from the table of verbs,
and a clause is a subject, a verb, an object, what prepositions bring in, and the words around the verb.
"""

from collections.abc import Sequence
from dataclasses import replace

from roadmend.safe.claims import Span
from roadmend.safe.reading.clauses import NOBODY, STRIKES, Actor, Clause
from roadmend.safe.reading.lexicon import VerbSense, word_set
from roadmend.safe.reading.mentions import Spoken
from roadmend.safe.reading.naming import Mention
from roadmend.safe.reading.referents import Referents, is_apart
from roadmend.safe.reading.tokens import NOTHING, Item, Sentence, Words

_TRANSITIVE = STRIKES | {"follow", "overtake", "avoid", "see", "after", "approach", "collide", "do", "own"}
_GOVERNING = frozenset({"intend", "begin", "avoid", "fail", "see", "say", "do", "stop", "slow", "park"})
_STRICT = frozenset({"intend", "begin", "fail"})  # govern only with "to"
_OBJECT_REACH = 4  # words between a verb and its object
_PASSIVE_REACH = 4  # words between "was" and "struck"


def read_clauses(sentences: Sequence[Sentence], spoken: Spoken) -> tuple[Clause, ...]:
    """The clauses of a text, in its order."""
    walker = _Walker(len(spoken.roll.vehicles), spoken.roll.own())
    for sentence, mentions in zip(sentences, spoken.mentions, strict=True):
        walker.walk(sentence, mentions)
    return tuple(walker.clauses)


class _Walker(Referents):
    """Goes through the words of a text, and makes clauses of them."""

    def walk(self, sentence: Sentence, mentions: Sequence[Mention]) -> None:
        self._begin(sentence, mentions)
        self.clause, self.acted, place = None, 0, 0
        self._wait(None)
        while place < len(self.items):
            group = self._group(place)
            if group is not None:
                self._place(place, *group)
                place = group[1] + 1
                continue
            if self._is_relative(place):
                is_road = self._is_of_road(place)
                self._flush()
                self.road = replace(NOBODY, span=self.items[place].span) if is_road else self.road
                self._wait(self.road if is_road else self.last)
            elif self._is_of_place(place):
                self._keep(self.items[place])
            elif _is_verb(self.items, place, after_actor=self._follows(place) or self._goes_on(place)):
                self._act(place)
            else:
                self._keep(self.items[place])
            place += 1
        self._flush()

    def _keep(self, item: Item) -> None:
        """Put a word where it belongs: behind the verb, or before it."""
        if self.clause is not None:
            self.clause.tail = Words((*self.clause.tail, item))
        else:
            self.head.append(item)

    def _wait(self, subject: Actor | None) -> None:
        """Begin anew, with a subject that has no verb yet."""
        self.pending, self.clause = subject, None
        self.head, self.of_head = list[Item](), list[tuple[Item, Actor]]()

    def _goes_on(self, place: int) -> bool:
        """Whether a place is after an "and" that goes on with a bare verb: "saw it come out and turn"."""
        verb = self.clause.verb if self.clause is not None else None
        return self.items.at(place - 1).low in {"and", "then"} and verb is not None and verb.form == "base"

    def _is_relative(self, place: int) -> bool:
        """Whether a "which" or "that" takes up the noun group before it."""
        item, after = self.items[place], self.items.at(place + 1)
        if not item.is_a("relative") or not self.last.span.end or place + 1 >= len(self.items):
            return False
        return item.low not in {"that", "thats"} or (after.is_a("auxiliary", "verb", "adverb") and self._follows(place))

    def _flush(self) -> None:
        """End what has a subject and no verb: "V1 northbound on Main Street"."""
        if self.pending is not None and self.head:
            end = self.head[-1].span
            span = Span(self.pending.span.start if self.pending.span.start < end.end else end.start, end.end)
            self.clauses.append(
                Clause(self.sentence, self.pending, None, others=self.of_head, head=Words(self.head), span=span)
            )
            self.focus = self.pending
        self.pending, self.of_head = None, []

    def _place(self, first: int, actor: Actor, last: int) -> None:
        """Give a noun group its part in the clause."""
        before, clause = self.items.at(first - 1), self.clause
        related = before.is_a("behind", "beside") or (
            before.is_a("ahead", "path", "ends") and before.low.endswith("of")
        )
        leads = before.is_a("preposition", "oncoming") and not before.is_a("number") and before.low != "before"
        if related or leads:
            self._bring(before, actor)
        elif before.low in {"and", "&", "/", "or"} and self._joins(first, last, actor):
            return
        elif (
            clause is not None
            and clause.object is None
            and _takes_object(clause)
            and self.items[first].low not in word_set("subject_pronouns")
        ):
            clause.object = actor
            if clause.lemma in {"drive", "operate"} and not clause.subject.vehicles:
                clause.subject = self.focus = replace(clause.subject, vehicles=actor.vehicles)
                for vehicle in actor.vehicles if clause.subject.gender else ():
                    self.genders[vehicle] = clause.subject.gender
        else:
            if self._leads_in(first):
                clause = self.clauses[-1]
                clause.subject = self.focus = actor  # "Entering the freeway from the ramp, the van"
            early = Words(self.head if clause is None and self.pending is None else ())
            self._flush()
            self._wait(actor)
            self.head = list(early) if early.has("bound", "ramp") else []  # "While southbound on Main Street, my car"
        if actor.vehicles:
            self.last = actor
            self.recent.extend(actor.vehicles)

    def _leads_in(self, first: int) -> bool:
        """Whether the sentence begins with a participle whose subject comes now."""
        opens = self.items.at(0).verb or (self.items.at(1).verb if self.items.at(0).is_a("conjunction") else None)
        alone = len([each for each in self.clauses if each.sentence is self.sentence]) == 1
        leads = opens is not None and opens.form == "ing" and alone and self.clauses[-1].verb is opens
        return leads and self.clause is self.clauses[-1] and self.items.at(first - 1).low == ","

    def _bring(self, preposition: Item, actor: Actor) -> None:
        if self.clause is not None:
            self.clause.others.append((preposition, actor))
        elif self.pending is not None:
            self.head.append(preposition)
            self.of_head.append((preposition, actor))

    def _joins(self, first: int, last: int, actor: Actor) -> bool:
        """Join "and V2" to what stands before it, unless it begins a clause of its own."""
        mine, clause = self.last, self.clause
        if not mine.span.end or mine.span.end != self.items.at(first - 2).span.end:
            return False
        both = tuple(dict.fromkeys([*mine.vehicles, *actor.vehicles]))
        joined = Actor(both, None, mine.is_person, Span(mine.span.start, actor.span.end))
        if self.pending is not None and self.pending.span == mine.span:
            self.pending = joined
        elif clause is None or _has_verb_next(self.items, last + 1):
            return False
        elif clause.object is not None and clause.object.span == mine.span:
            clause.object = joined
        elif clause.others and clause.others[-1][1].span == mine.span:
            clause.others[-1] = (clause.others[-1][0], joined)
        else:
            return False
        self.last = joined
        return True

    def _act(self, place: int) -> None:
        """Begin the clause of a verb."""
        item, old = self.items[place], self.clause
        verb = item.verb
        if verb is None:
            return
        nearby = self.items.cut(max(self.acted, place - _PASSIVE_REACH), place)
        subject, governed = self._after(place, verb) or self._subject(place, verb)
        be = max((at for at, each in enumerate(nearby) if each.get("auxiliary") == "be"), default=None)
        after_be = nearby.cut(be + 1) if be is not None else Words()
        is_be = be is not None and not after_be.says({",", ";"})
        is_be &= verb.form != "past" or not after_be.has("conjunction")  # "was damaged and came"
        by = verb.kind in STRIKES and self.items.cut(place + 1, place + 3).says({"by"})
        near = nearby.cut(max((at + 1 for at, each in enumerate(nearby) if each.low == ";"), default=0))
        is_denied = near.cut(len(near) - 3).has("negation") and verb.kind != "fail"
        missed = near.at(len(near) - 1).low in word_set("near_misses") or (
            near.cut(len(near) - 2).says({"would", "could", "might"}) and near.at(len(near) - 1).low == "have"
        )
        is_denied |= missed and verb.kind in STRIKES | {"collide"}
        is_denied |= verb.kind == "avoid" and old is not None and self.pending is None and old.kind == "fail"
        start = subject.span.start if subject.span.end and subject.span.start >= self.sentence.span.start else None
        self.clauses.append(
            Clause(
                self.sentence,
                subject,
                verb,
                is_passive=verb.form in {"both", "participle", "past"} and (is_be or by),
                is_denied=is_denied,
                governed=governed,
                others=self.of_head,
                head=Words(self.head),
                span=Span(item.span.start if start is None else min(start, item.span.start), item.span.end),
            )
        )
        self._wait(None)
        self.clause, self.acted = self.clauses[-1], place + 1
        self.focus = subject if subject.vehicles else self.focus

    def _after(self, place: int, verb: VerbSense) -> tuple[Actor, frozenset[str]] | None:
        """Who stands behind the verb: "from the ramp came a van", "behind it was a bus"."""
        mention = self.starts.get(place + 1)
        first = self.items.at(0) if self.clause is None else NOTHING
        comes = verb.lemma in {"come", "emerge", "appear", "follow", "approach", "be", "stand", "sit"}
        if self.pending is not None or mention is None or not comes or not first.is_a("preposition", "behind"):
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
        if old is None:
            return self.focus, nothing
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
        return self._follows(place) and not is_subject and verb.form in {"ing", "both", "participle"}


def _takes_object(clause: Clause) -> bool:
    takes = clause.kind in _TRANSITIVE or clause.lemma in {"drive", "operate", "ride"}
    return takes and not clause.is_passive and len(clause.tail) <= _OBJECT_REACH and not is_apart(clause.tail, ",;(")


def _has_verb_next(items: Words, place: int) -> bool:
    for item in items.cut(place, place + 4):
        if item.low in ",;" or item.is_a("preposition", "conjunction"):
            return False
        if item.is_a("auxiliary", "verb"):
            return True
    return False


def _is_verb(items: Words, place: int, *, after_actor: bool) -> bool:
    """Whether a word is the verb that it may be, and not a noun."""
    item, before, after = items[place], items.at(place - 1), items.at(place + 1)
    verb = item.verb
    if verb is None or (item.is_a("lanekind") and after.is_a("lane", "lanekind")):
        return False
    if item.low == "left":  # the hand, or the past of "leave"
        led = after_actor or before.is_a("auxiliary", "conjunction") or before.low == ","
        goes = after.is_a("determiner", "road", "shoulder") or after.get("pronoun") == "its"
        return led and goes and not after.is_a("hand", "lane")
    counted = before.is_a("determiner") and not before.is_a("number")  # not the "two" of "unit two struck"
    owned = counted or before.get("pronoun") in {"its", "own"}
    if owned and verb.form != "ing" and before.low not in word_set("loose_determiners"):
        return False
    if verb.form in {"base", "s"}:
        led = (
            before.is_a("auxiliary", "relative", "negation", "pronoun")
            or before.low in word_set("base_verb_leads")
            or before.low.endswith(" to")
            or (before.verb is not None and before.verb.kind == "intend")
        )
        return after_actor or led or (before.low in {"and", "then", ","} and verb.form == "s")
    if verb.form == "ing" and before.is_a("determiner"):
        return not after.low or after.is_a("determiner", "preposition", "hand")
    return not (item.is_a("parked", "stationary") and after.is_a("thing", "body", "name"))
