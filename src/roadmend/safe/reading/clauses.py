"""Sentences taken apart: who does what, to whom, where, and how certain it is.

A shallow parser: noun groups are the mentions of vehicles and of their parts, verb groups come from the table of verbs,
and a clause is a subject, a verb, an object, what prepositions bring in, and the words around the verb.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

from roadmend.safe.claims import Span
from roadmend.safe.dsl import Side
from roadmend.safe.reading.lexicon import VerbSense
from roadmend.safe.reading.mentions import Mention, MentionKind, Spoken
from roadmend.safe.reading.tokens import Item, Sentence

STRIKES = frozenset({"strike", "strike_rear", "strike_side", "strike_swipe"})
_TRANSITIVE = STRIKES | {"follow", "overtake", "avoid", "see", "after", "approach", "collide", "do", "own"}
_GOVERNING = frozenset({"intend", "begin", "avoid", "fail", "see", "say", "do"})
_NOUN_LIKE = frozenset({"base", "s"})
_OBJECT_REACH = 4  # words between a verb and its object
_PASSIVE_REACH = 4  # words between "was" and "struck"
_TO = "to"


@dataclass(frozen=True, slots=True)
class Part:
    """A part of a vehicle.

    Attributes:
        side: where it is; None for one side, not said which.
        other: its second side: "the left front" is in front, and on the left.
        is_flank: whether it is a side rather than an end.
    """

    side: Side | None
    other: Side | None
    is_flank: bool


@dataclass(frozen=True, slots=True)
class Actor:
    """One or more vehicles in a clause.

    Attributes:
        vehicles: by place in the cast; empty where it is open which.
        part: that is spoken of.
        is_person: whether it is the driver who is spoken of.
        span: in the summary.
    """

    vehicles: tuple[int, ...]
    part: Part | None
    is_person: bool
    span: Span


@dataclass(slots=True)
class Clause:
    """One statement.

    Attributes:
        sentence: that it stands in.
        subject: who does it.
        verb: what; None where there is none.
        is_passive: whether it is done to the subject.
        is_denied: whether it is said not to be.
        governed: kinds of the verbs that it depends on: "began", "tried", "failed".
        is_past: whether it was before what is told ("had been").
        object: to whom.
        others: what prepositions bring in, each with its preposition.
        head: words between subject and verb.
        tail: words after the verb.
        span: in the summary.
    """

    sentence: Sentence
    subject: Actor | None
    verb: VerbSense | None
    is_passive: bool = False
    is_denied: bool = False
    governed: frozenset[str] = frozenset()
    is_past: bool = False
    object: Actor | None = None
    others: list[tuple[Item, Actor]] = field(default_factory=list)
    head: list[Item] = field(default_factory=list)
    tail: list[Item] = field(default_factory=list)
    span: Span = field(default=Span(0, 0))

    @property
    def kind(self) -> str:
        """Of the verb; empty where there is none."""
        return self.verb.kind if self.verb is not None else ""

    @property
    def is_real(self) -> bool:
        """Whether it is said to have happened, not only to have been meant or missed."""
        return not self.is_denied and not self.governed & {"intend", "avoid"}


def read_clauses(sentences: Sequence[Sentence], spoken: Spoken) -> tuple[Clause, ...]:
    """The clauses of a text, in its order."""
    walker = _Walker(len(spoken.roll.vehicles))
    for sentence, mentions in zip(sentences, spoken.mentions, strict=True):
        walker.walk(sentence, mentions)
    return tuple(walker.clauses)


class _Walker:
    """Goes through the words of a text, and remembers who was last spoken of."""

    def __init__(self, count: int) -> None:
        self.count = count
        self.clause: Clause | None = None
        self.pending: Actor | None = None  # a subject that waits for its verb
        self.clauses: list[Clause] = []
        self.focus: Actor | None = None  # the last subject
        self.last: Actor | None = None  # the last one spoken of
        self.recent: list[int] = []  # vehicles in the order in which they were spoken of

    def walk(self, sentence: Sentence, mentions: Sequence[Mention]) -> None:
        items = sentence.items
        starts = {mention.first: mention for mention in mentions}
        self.sentence, self.clause, self.pending = sentence, None, None
        self.head: list[Item] = []
        self.of_head: list[tuple[Item, Actor]] = []
        self.acted = 0  # where the last verb ended
        place = 0
        while place < len(items):
            group = self._group(items, place, starts)
            if group is not None:
                actor, last = group
                self._place(items, place, last, actor)
                place = last + 1
                continue
            item = items[place]
            if item.is_a("relative") and self.last is not None and self._is_relative(items, place):
                self._flush()
                self.pending, self.clause, self.head = self.last, None, []
            elif _is_verb(items, place, after_actor=self._is_after_actor(items, place)):
                self._act(items, place)
            else:
                self._words().append(item)
            place += 1
        self._flush()

    def _words(self) -> list[Item]:
        """Where the words go that stand here."""
        return self.clause.tail if self.clause is not None else self.head

    def _is_after_actor(self, items: Sequence[Item], place: int) -> bool:
        return self.last is not None and place > 0 and self.last.span.end == items[place - 1].span.end

    def _is_relative(self, items: Sequence[Item], place: int) -> bool:
        """Whether a "which" or "that" takes up the noun group before it."""
        if place + 1 >= len(items):
            return False
        follows = items[place + 1].is_a("auxiliary", "verb", "adverb")
        return items[place].low != "that" or (follows and self._is_after_actor(items, place))

    def _flush(self) -> None:
        if self.pending is not None and self.head:
            span = (
                Span(self.pending.span.start, self.head[-1].span.end)
                if self.pending.span.start < self.head[-1].span.end
                else self.head[-1].span
            )
            clause = Clause(self.sentence, self.pending, None, others=self.of_head, head=list(self.head), span=span)
            self.clauses.append(clause)
            self.focus = self.pending
        self.pending, self.of_head = None, []

    def _group(self, items: Sequence[Item], place: int, starts: dict[int, Mention]) -> tuple[Actor, int] | None:
        """A noun group that begins here: a vehicle, a part of one, or a part whose owner is open."""
        mention = starts.get(place)
        if mention is not None:
            last = mention.last
            actor = self._resolve(mention, items)
            after = last + 1
            if after < len(items) and items[after].low == "'s":
                after += 1
            part = (
                _part(items, after, is_led=True)
                if mention.kind is MentionKind.POSSESSIVE
                or after > last + 1
                or items[place].kinds.get("pronoun") == "own"
                or mention.description is not None
                else None
            )
            if part is None and after > last + 1:
                return replace(actor, vehicles=()), last + 1  # "V2's lane" is a place
            if part is not None:
                return replace(
                    actor, part=part[0], is_person=False, span=Span(actor.span.start, items[part[1]].span.end)
                ), part[1]
            return actor, last
        led = items[place].is_a("determiner") and place + 1 < len(items)
        part = (
            _part(items, place + 1, is_led=True)
            if led and (place + 1) not in starts
            else _part(items, place, is_led=False)
        )
        if part is None:
            return None
        found, last = part
        span = Span(items[place].span.start, items[last].span.end)
        if last + 2 < len(items) and items[last + 1].low in {"of", "to"}:
            owner = starts.get(last + 2)
            if owner is not None and items[last + 1].low == "of":
                actor = self._resolve(owner, items)
                return replace(actor, part=found, is_person=False, span=Span(span.start, actor.span.end)), owner.last
        return Actor((), found, is_person=False, span=span), last

    def _resolve(self, mention: Mention, items: Sequence[Item]) -> Actor:
        vehicles = mention.vehicles
        here = self.clause.subject if self.clause is not None else self.pending
        focus = here or self.focus
        after = items[mention.last + 1] if mention.last + 1 < len(items) else None
        if vehicles:
            pass
        elif (
            mention.kind is MentionKind.IT
            and mention.last > mention.first
            and after is not None
            and after.is_a("ahead", "behind")
        ):
            vehicles = ()  # "the vehicle in front of him"
        elif mention.kind is MentionKind.BOTH:
            vehicles = self._both(mention)
        elif mention.kind is MentionKind.OTHER:
            mine = focus.vehicles if focus is not None else ()
            rest = [each for each in range(min(self.count, 2)) if each not in mine]
            vehicles = (rest[0],) if len(rest) == 1 else ()
        elif mention.kind is MentionKind.POSSESSIVE:
            owner = here if here is not None and here.vehicles else self.last or focus
            vehicles = owner.vehicles[:1] if owner is not None else ()
        elif mention.kind in {MentionKind.IT, MentionKind.ONE, MentionKind.PERSON} and not mention.is_new:
            before = items[mention.first - 1] if mention.first else None
            is_object = (
                self.clause is not None
                and self.clause.kind in _TRANSITIVE
                and not any(item.is_a("conjunction") or item.low == "," for item in self.clause.tail)
            )
            if before is not None and before.is_a("ahead", "behind", "beside") and here is not None:
                vehicles = next(((each,) for each in reversed(self.recent) if each not in here.vehicles), ())
            elif (
                is_object
                and here is not None
                and self.clause is not None
                and self.clause.kind in STRIKES | {"avoid", "see", "follow", "overtake", "after"}
            ):
                known = [self.last.vehicles] if self.last is not None and self.last.vehicles != here.vehicles else []
                rest = [each for each in range(min(self.count, 2)) if each not in here.vehicles]
                vehicles = known[0] if known else (rest[0],) if len(rest) == 1 else ()
            elif (
                mention.kind is MentionKind.IT
                and here is not None
                and here.is_person
                and self.last is not None
                and not self.last.is_person
                and self.last.vehicles
            ):
                vehicles = self.last.vehicles[:1]  # "I did not see the van until it hit me"
            else:
                vehicles = (
                    focus.vehicles
                    if focus is not None and focus.vehicles
                    else self.last.vehicles
                    if self.last is not None
                    else ()
                )
                vehicles = vehicles[:1] if mention.kind is not MentionKind.ONE or len(vehicles) == 1 else vehicles
        return Actor(vehicles, None, mention.is_person, mention.span)

    def _both(self, mention: Mention) -> tuple[int, ...]:
        """The vehicles that "both" or "they all" mean: of more than two, the last that have done something."""
        if self.count <= 2 or "all" in self.sentence.items[mention.first].low:
            return tuple(range(min(self.count, 3)))
        done = [each.subject.vehicles[0] for each in self.clauses if each.subject is not None and each.subject.vehicles]
        recent = [*dict.fromkeys([*reversed(done), *range(self.count)])]
        return tuple(sorted(recent[:2]))

    def _place(self, items: Sequence[Item], first: int, last: int, actor: Actor) -> None:
        """Give a noun group its part in the clause."""
        before = items[first - 1] if first else None
        clause = self.clause
        if (
            before is not None
            and before.is_a("ahead", "behind", "beside", "path", "ends")
            and (before.low.endswith("of") or before.is_a("behind", "beside"))
        ) or (
            before is not None
            and before.is_a("preposition", "oncoming")
            and not before.is_a("number")
            and before.low != "before"
        ):
            self._bring(before, actor)
        elif before is not None and before.low in {"and", "&", "/", "or"} and self._joins(items, first, last, actor):
            return
        elif clause is not None and clause.object is None and self._takes_object(clause):
            clause.object = actor
            if (
                clause.verb is not None
                and clause.verb.lemma in {"drive", "operate"}
                and clause.subject is not None
                and not clause.subject.vehicles
            ):
                clause.subject = replace(clause.subject, vehicles=actor.vehicles)
                self.focus = clause.subject
        else:
            self._flush()
            self.pending, self.clause, self.head = actor, None, []
        if actor.vehicles:
            self.last = actor
            self.recent = [*self.recent, *actor.vehicles]

    def _bring(self, preposition: Item, actor: Actor) -> None:
        if self.clause is not None:
            self.clause.others.append((preposition, actor))
        elif self.pending is not None:
            self.head.append(preposition)
            self.of_head.append((preposition, actor))

    def _takes_object(self, clause: Clause) -> bool:
        drives = clause.verb is not None and clause.verb.lemma in {"drive", "operate", "ride"}
        near = len(clause.tail) <= _OBJECT_REACH and not any(
            item.low in ",;(" or item.is_a("conjunction") for item in clause.tail
        )
        return near and (clause.kind in _TRANSITIVE or drives) and not clause.is_passive

    def _joins(self, items: Sequence[Item], first: int, last: int, actor: Actor) -> bool:
        """Join "and V2" to what stands before it, unless it begins a clause of its own."""
        if self.last is None or first < 2 or self.last.span.end != items[first - 2].span.end:
            return False
        joined = Actor(
            (*self.last.vehicles, *(each for each in actor.vehicles if each not in self.last.vehicles)),
            None,
            self.last.is_person,
            Span(self.last.span.start, actor.span.end),
        )
        if self.pending is not None and self.pending.span == self.last.span:
            self.pending = joined
        elif (
            self.clause is not None
            and self.clause.object is not None
            and self.clause.object.span == self.last.span
            and not _has_verb_next(items, last + 1)
        ):
            self.clause.object = joined
        elif (
            self.clause is not None
            and self.clause.others
            and self.clause.others[-1][1].span == self.last.span
            and not _has_verb_next(items, last + 1)
        ):
            self.clause.others[-1] = (self.clause.others[-1][0], joined)
        else:
            return False
        self.last = joined
        return True

    def _act(self, items: Sequence[Item], place: int) -> None:
        """Begin the clause of a verb."""
        item = items[place]
        verb = item.verb
        assert verb is not None
        old = self.clause
        governed: frozenset[str] = frozenset()
        if self.pending is not None:
            subject: Actor | None = self.pending
        elif old is not None and self._is_reduced(items, place, verb, old):
            subject = self.last
        elif (
            old is not None
            and old.kind in {"see", "say"}
            and old.object is not None
            and items[place - 1].is_a("auxiliary", "negation")
        ):
            subject = old.object  # "he saw that the car was stopped"
        else:
            subject = old.subject if old is not None else self.focus
            if old is not None and self._governs(old, item):
                governed = old.governed | {old.kind}
                if old.is_denied and old.kind in {"intend", "begin", "do"}:
                    governed |= {"avoid"}
                if old.kind == "avoid" and (
                    old.is_denied or (old.governed & {"fail", "intend"} and old.governed & {"fail"})
                ):
                    governed = governed - {"avoid"}
        nearby = items[max(self.acted, place - _PASSIVE_REACH, 0) : place]
        self.acted = place + 1
        auxiliaries = (
            [each.kinds.get("auxiliary") for each in nearby if each.is_a("auxiliary")]
            if not any(each.low in ",;" for each in nearby[-1:])
            else []
        )
        follows_by = any(each.low == "by" for each in items[place + 1 : place + 3])
        is_passive = verb.form in {"both", "participle", "past"} and (
            ("be" in auxiliaries) or (follows_by and verb.kind in STRIKES)
        )
        is_denied = any(each.is_a("negation") for each in nearby[-3:]) and verb.kind != "fail"
        could_not = verb.kind == "avoid" and (
            is_denied or (old is not None and self.pending is None and old.kind == "fail")
        )
        clause = Clause(
            self.sentence,
            subject,
            verb,
            is_passive,
            is_denied,
            governed,
            is_past=any(each.low in {"had", "had been"} for each in nearby),
            head=[*self.head],
            span=Span(
                min(subject.span.start, item.span.start)
                if subject is not None and subject.span.start >= self.sentence.span.start
                else item.span.start,
                item.span.end,
            ),
        )
        if could_not:
            clause.is_denied = True
        if old is None or self.pending is not None:
            clause.others.extend(self.of_head)
        self.of_head = []
        self.clauses.append(clause)
        self.clause, self.pending, self.head = clause, None, []
        if subject is not None and subject.vehicles:
            self.focus = subject

    def _governs(self, old: Clause, item: Item) -> bool:
        """Whether a verb depends on the one before it: "attempted to turn", "was stopped waiting to turn"."""
        if old.kind not in _GOVERNING | {"stop", "slow", "park"}:
            return False
        if old.kind in {"intend", "begin", "fail"} and any(each.kinds and each.low != _TO for each in old.tail):
            return False
        apart = any(each.low in ",;" or each.is_a("conjunction") for each in old.tail)
        return not apart and not any(actor.span.end > item.span.start for _, actor in old.others)

    def _is_reduced(self, items: Sequence[Item], place: int, verb: VerbSense, old: Clause) -> bool:
        """Whether the verb says something of the noun group before it: "struck V2 parked at the curb"."""
        if self.last is None or place == 0:
            return False
        at = place - 1
        while at and items[at].low in {"also", "still", "being", "then", "likewise"}:
            at -= 1
        adjacent = items[at].span.end == self.last.span.end
        is_subject = old.subject is not None and old.subject.span == self.last.span
        return adjacent and not is_subject and verb.form in {"ing", "both", "participle"}


def _has_verb_next(items: Sequence[Item], place: int) -> bool:
    for at in range(place, min(place + 4, len(items))):
        if items[at].low in ",;" or items[at].is_a("preposition", "conjunction"):
            return False
        if items[at].is_a("auxiliary") or items[at].is_a("verb"):
            return True
    return False


def _is_verb(items: Sequence[Item], place: int, *, after_actor: bool) -> bool:
    item = items[place]
    verb = item.verb
    if verb is None:
        return False
    before = items[place - 1] if place else None
    after = items[place + 1] if place + 1 < len(items) else None
    if item.low == "left":  # the hand, or the past of "leave"
        led = after_actor or (before is not None and (before.is_a("auxiliary", "conjunction") or before.low == ","))
        return (
            led
            and after is not None
            and (after.is_a("determiner", "road", "shoulder") or after.kinds.get("pronoun") == "its")
            and not after.is_a("hand", "lane")
        )
    if after is not None and after.is_a("lane", "lanekind") and item.is_a("lanekind"):
        return False
    if (
        before is not None
        and (before.is_a("determiner") or before.kinds.get("pronoun") in {"its", "own"})
        and verb.form != "ing"
        and before.low not in {"that", "this", "both", "all", "other", "each"}
    ):
        return False
    if verb.form in _NOUN_LIKE:
        led = after_actor or (
            before is not None
            and (
                before.low in {_TO, "didn't", "n't", "just", "then", "also", "never"}
                or before.is_a("auxiliary", "relative", "negation", "pronoun")
            )
        )
        coordinated = before is not None and before.low in {"and", "then", ","} and verb.form == "s"
        return led or coordinated
    if (
        verb.form == "ing"
        and before is not None
        and before.is_a("determiner")
        and after is not None
        and not after.is_a("determiner", "preposition", "hand")
    ):
        return False
    return not (item.is_a("parked", "stationary") and after is not None and after.is_a("thing", "body", "name"))


def _part(items: Sequence[Item], place: int, *, is_led: bool) -> tuple[Part, int] | None:
    """A part of a vehicle that is named here, and its last word."""
    last, hands, ends, is_flank, has_part = place - 1, [], [], False, False
    for at in range(place, len(items)):
        item = items[at]
        if item.is_a("flank"):
            hands.append(item.kinds["flank"])
            is_flank = has_part = True
        elif item.is_a("hand") and not item.is_a("part") and (has_part or _leads_to_part(items, at + 1)):
            hands.append(item.kinds["hand"])
        elif item.is_a("part"):
            kind = item.kinds["part"]
            has_part = True
            if kind == "Side":
                is_flank = True
            elif kind in {"Front", "Rear"}:
                ends.append(kind)
        elif (
            item.low in {"most", "/", "-"} and at > place and at + 1 < len(items) and items[at + 1].is_a("part", "hand")
        ):
            continue
        else:
            break
        last = at
    if not has_part or (not hands and not ends and not is_flank):
        return None
    after = items[last + 1] if last + 1 < len(items) else None
    single = last == place and not items[place].is_a("flank") and " " not in items[place].low
    if single and not is_led and not (after is not None and after.low == "of"):
        return None
    if single and items[place].low in {"end", "quarter", "wheel", "wing", "surface", "forward", "area"}:
        return None
    if after is not None and (
        after.is_a("lane", "seat", "curve", "road")
        or after.low
        in {
            "airbag",
            "airbags",
            "seat",
            "passenger",
            "occupant",
            "seats",
            "row",
            "tire",
            "window",
            "wheel",
            "yard",
            "to",
        }
        or (after.is_a("person") and not after.is_a("body"))
    ):
        return None
    if (
        after is not None
        and after.low == "of"
        and last + 2 < len(items)
        and any(
            items[each].is_a("road", "shoulder", "junction", "driveway", "lane")
            for each in range(last + 2, min(last + 4, len(items)))
        )
    ):
        return None  # "the left side of the road"
    if any(items[each].is_a("compass") for each in range(max(0, place - 2), place)) and is_flank and not hands:
        return None  # "the north side"
    hand = Side(hands[-1]) if hands else None
    end = Side(ends[-1]) if ends else None
    if is_flank and (hand or not end):
        return Part(hand, end, is_flank=True), last
    return Part(end, hand, is_flank=is_flank), last


def _leads_to_part(items: Sequence[Item], place: int) -> bool:
    return place < len(items) and (
        items[place].is_a("part", "flank") or (items[place].is_a("hand") and _leads_to_part(items, place + 1))
    )


def spoken_items(clause: Clause) -> Iterator[Item]:
    """All words of a clause but those that name vehicles."""
    yield from clause.head
    yield from clause.tail
