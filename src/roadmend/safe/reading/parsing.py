"""Sentences taken apart into clauses.

A shallow parser: noun groups are the mentions of vehicles and of their parts, verb groups come from the table of verbs,
and a clause is a subject, a verb, an object, what prepositions bring in, and the words around the verb.
"""

from collections.abc import Sequence
from dataclasses import replace

from roadmend.safe.claims import Span
from roadmend.safe.reading.clauses import NOBODY, STRIKES, Actor, Clause
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.mentions import Spoken
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.referents import is_apart
from roadmend.safe.reading.subjects import Subjects
from roadmend.safe.reading.tokens import Item, Sentence, Words

_TRANSITIVE = STRIKES | {"follow", "overtake", "avoid", "see", "after", "approach", "collide", "do", "own"}
_OBJECT_REACH = 4  # words between a verb and its object
_PASSIVE_REACH = 4  # words between "was" and "struck"


def read_clauses(sentences: Sequence[Sentence], spoken: Spoken) -> tuple[Clause, ...]:
    """The clauses of a text, in its order."""
    walker = _Walker(len(spoken.roll.vehicles), spoken.roll.own())
    rows = zip(sentences, spoken.mentions, strict=True)
    if not any(sentence.items[each.first].get("pronoun") in {"self", "own"} for sentence, row in rows for each in row):
        walker.writer = ()  # whom an insurer calls its insured is "he"
    for sentence, mentions in zip(sentences, spoken.mentions, strict=True):
        walker.walk(sentence, mentions)
    return tuple(walker.clauses)


class _Walker(Subjects):
    """Goes through the words of a text, and makes clauses of them."""

    def walk(self, sentence: Sentence, mentions: Sequence[Mention]) -> None:
        self._begin(sentence, mentions)
        self.before: list[tuple[Item, Actor]] = []
        self.clause, self.acted, place = None, 0, 0
        self._wait(None)
        while place < len(self.items):
            if self._is_aside(place):
                place += 2
                continue
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

    def _is_aside(self, place: int) -> bool:
        """Whether "I think" stands between commas and says nothing more."""
        mention, verb = self.starts.get(place), self.items.at(place + 1).verb
        is_mine = mention is not None and mention.kind is MentionKind.SELF and mention.last == place
        return (
            is_mine and verb is not None and verb.kind == "say" and self.items.at(place + 2).low in {",", "", ")", "-"}
        )

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
        compared = before.low == "than" or (
            before.low == "as" and self.items.cut(first - 5, first - 1).says({"same", "as"})
        )
        if self._is_seat(first):
            leads = False  # "some clown in a Kia pulls out"
        if related or leads or compared:
            self._bring(before, actor)
        elif before.low in {"and", "&", "/", "or"} and self._joins(first, last, actor):
            return
        elif (
            clause is not None
            and clause.object is None
            and _takes_object(clause)
            and not self._begins(last)
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
            self.of_head, self.before = self.before, []
            self.head = (
                list(early) if early.has("bound", "ramp", "oncoming") else []
            )  # "While southbound on Main Street, my car"
        if actor.vehicles:
            self.last = actor
            self.thing = self.thing if actor.is_person else actor
            self.recent.extend(actor.vehicles)

    def _is_seat(self, first: int) -> bool:
        """Whether somebody whom no table knows sits in a vehicle: "this joker in a Kia"."""
        mention, noun, lead = self.starts.get(first), self.items.at(first - 2), self.items.at(first - 3)
        plain = not noun.kinds and noun.low.isalpha() and noun.low.islower() and not noun.is_name
        return (
            mention is not None
            and mention.is_new
            and self.items.at(first - 1).low == "in"
            and plain
            and lead.is_a("determiner")
        )

    def _begins(self, last: int) -> bool:
        """Whether a noun group after a verb of seeing begins a clause: "did not hear how a van came"."""
        after, kind = self.items.at(last + 1).verb, self.clause.kind if self.clause is not None else ""
        return kind in {"see", "say"} and after is not None and after.form in {"past", "s"}

    def _leads_in(self, first: int) -> bool:
        """Whether the sentence begins with a participle whose subject comes now."""
        opens = self.items.at(0).verb or (self.items.at(1).verb if self.items.at(0).is_a("conjunction") else None)
        alone = len([each for each in self.clauses if each.sentence is self.sentence]) == 1
        leads = opens is not None and opens.form == "ing" and alone and self.clauses[-1].verb is opens
        lead = self.items.at(first - 1)  # "Coming the other way was a van"
        return leads and self.clause is self.clauses[-1] and (lead.low == "," or lead.get("auxiliary") == "be")

    def _bring(self, preposition: Item, actor: Actor) -> None:
        if self.clause is not None:
            self.clause.others.append((preposition, actor))
        elif self.pending is not None:
            self.head.append(preposition)
            self.of_head.append((preposition, actor))
        elif preposition.is_a("ahead", "behind", "beside"):
            self.before = [(preposition, actor)]  # "Behind him a van wanted to turn"

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
        is_be &= verb.form != "past" or not after_be.has(
            "conjunction", "preposition", "pronoun"
        )  # "was damaged and came"
        by = verb.kind in STRIKES and self.items.cut(place + 1, place + 3).says({"by"})
        near = nearby.cut(max((at + 1 for at, each in enumerate(nearby) if each.low == ";"), default=0))
        is_denied = near.cut(len(near) - 3).has("negation") and verb.kind != "fail"
        missed = near.at(len(near) - 1).low in word_set("near_misses") or (
            near.cut(len(near) - 2).says({"would", "could", "might"}) and near.at(len(near) - 1).low == "have"
        )
        is_denied |= missed and verb.kind in STRIKES | {"collide"}
        is_denied |= near.cut(len(near) - 3).says({"if"}) and near.says({"as"})  # "slowed as if to turn"
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
    if owned and verb.form == "ing" and after.is_a("part", "flank"):
        return False  # "his sliding door"
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
