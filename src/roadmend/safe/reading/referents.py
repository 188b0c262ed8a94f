"""Who is meant: the vehicles that the noun groups of a text stand for, by what was spoken of before."""

from collections.abc import Sequence
from dataclasses import replace

from roadmend.safe.claims import Span
from roadmend.safe.reading.clauses import NOBODY, STRIKES, Actor, Clause
from roadmend.safe.reading.lexicon import word_set
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.parts import read_part
from roadmend.safe.reading.tokens import Sentence, Words

_OTHERS_OBJECT = STRIKES | {"avoid", "see", "follow", "overtake", "after"}  # "it struck him": not itself
_BRACKET = 8  # words of a bracket between a noun group and its verb


class Referents:
    """Remembers who was spoken of, and tells who is meant next."""

    def __init__(self, count: int, own: tuple[int, ...]) -> None:
        self.count, self.own = count, own
        self.writer = own  # who says "I"
        self.clauses: list[Clause] = []
        self.clause: Clause | None = None
        self.pending: Actor | None = None  # a subject that waits for its verb
        # The last subject; before there is one, who writes without "I" speaks of himself.
        self.focus = replace(NOBODY, vehicles=own, is_person=True) if own else NOBODY
        self.road: Actor | None = None  # of which a relative clause speaks
        self.last = NOBODY  # the last one spoken of
        self.thing = NOBODY  # the last one spoken of that is no person
        self.genders: dict[int, str] = {}  # of who drives
        self.persons: set[int] = set()  # whose gender a noun has told
        self.recent: list[int] = []  # vehicles in the order in which they were spoken of
        self.items = Words()
        self.starts: dict[int, Mention] = {}

    def _begin(self, sentence: Sentence, mentions: Sequence[Mention]) -> None:
        """Go on to the next sentence."""
        self.sentence, self.items = sentence, sentence.items
        self.starts = {mention.first: mention for mention in mentions}

    def _follows(self, place: int) -> bool:
        """Whether a place is directly after the last noun group, or after what is in brackets behind it."""
        if self.items.at(place - 1).low == ")":
            opened = [at for at in range(max(0, place - _BRACKET), place) if self.items[at].low == "("]
            place = opened[-1] if opened else place
        return place > 0 and bool(self.last.span.end) and self.last.span.end == self.items[place - 1].span.end

    def _is_of_place(self, place: int) -> bool:
        """Whether a participle tells of a road before anybody is named: "On the slip road joining the A1, a van"."""
        item, verb = self.items.at(place - 1), self.items[place].verb
        return (
            verb is not None
            and verb.form == "ing"
            and self.pending is None
            and self.clause is None
            and item.is_a("ramp", "road", "lane", "junction")
            and self.items[0].is_a("preposition")
        )

    def _is_of_road(self, place: int) -> bool:
        """Whether "which" takes up the name of a road: "on Mill Lane, which ends at Route 12"."""
        back = place - 1 - (self.items.at(place - 1).low == ",")
        item, before = self.items.at(back), self.items.at(back - 1)
        named = item.is_a("road") or (item.is_a("lane") and item.is_name) or (item.is_name and not item.kinds)
        numbered = item.is_a("number") and before.is_a("road")
        return (named or numbered) and self.last.span.end < item.span.end and self.items[place].low in {"which", "that"}

    def _group(self, place: int) -> tuple[Actor, int] | None:
        """A noun group that begins here, and its last word: a vehicle, or a part of one, whose owner may be open."""
        mention = self.starts.get(place)
        if mention is not None:
            return self._owner(mention, place)
        led = self.items[place].is_a("determiner") and (place + 1) not in self.starts
        found = read_part(self.items, place + led, is_led=led)
        if found is None:
            return None
        part, last = found
        span = self.items.span(place, last)
        owner = self.starts.get(last + 2)
        if owner is not None and self.items.at(last + 1).low == "of":
            actor = self._resolve(owner)
            return replace(actor, part=part, is_person=False, span=Span(span.start, actor.span.end)), owner.last
        return Actor((), part, is_person=False, span=span), last

    def _owner(self, mention: Mention, place: int) -> tuple[Actor, int]:
        """A mention with the part of it that is named after it: "V1's left side", "its front"."""
        actor, last = self._resolve(mention), mention.last
        is_short = mention.kind in {MentionKind.ONE, MentionKind.IT, MentionKind.SELF} and mention.first == last
        owned = self.items.at(last + 1).low == "'s" and not is_short  # "she's" is "she is"
        is_own = self.items[place].get("pronoun") == "own"
        may_own = owned or is_own or mention.kind is MentionKind.POSSESSIVE or mention.description is not None
        found = read_part(self.items, last + 1 + owned, is_led=True) if may_own else None
        if found is not None:
            span = Span(actor.span.start, self.items[found[1]].span.end)
            return replace(actor, part=found[0], is_person=False, span=span), found[1]
        return (replace(actor, vehicles=()), last + 1) if owned else (actor, last)  # "V2's lane" is a place

    def _resolve(self, mention: Mention) -> Actor:
        """Which vehicles a mention means here."""
        word = self.items.cut(mention.first, mention.last + 1).first("gender")
        gender = word.get("gender") if word is not None else ""
        here = self.clause.subject if self.clause is not None else self.pending
        is_weak = mention.kind is MentionKind.POSSESSIVE and not (here is not None and here.vehicles)
        vehicles = mention.vehicles or self._of_gender(self._meant(mention), gender, is_weak=is_weak)
        if len(vehicles) == 1 and gender:
            self.genders.setdefault(vehicles[0], gender)
            self.persons |= {*vehicles} if mention.kind is MentionKind.PERSON and mention.vehicles else set()
        return Actor(vehicles, None, mention.is_person, mention.span, gender)

    def _of_gender(self, vehicles: tuple[int, ...], gender: str, *, is_weak: bool) -> tuple[int, ...]:
        """The same, unless it is known that a man drives and "she" is spoken of."""
        if len(vehicles) != 1 or not gender or self.genders.get(vehicles[0]) == gender:
            return vehicles
        same = [each for each, known in self.genders.items() if known == gender]
        if vehicles[0] not in self.genders:
            is_sure = self.persons == set(same) or is_weak
            return (same[0],) if len(same) == 1 and is_sure else vehicles
        return (same[-1],) if same else self._but(vehicles)

    def _meant(self, mention: Mention) -> tuple[int, ...]:
        here = (self.clause.subject if self.clause is not None else self.pending) or NOBODY
        focus = here if here.vehicles else self.focus
        match mention.kind:
            case MentionKind.IT if self.items[mention.first].is_a("pronoun") and self.items[mention.first].get(
                "pronoun"
            ) in {"former", "latter"}:
                return self._of_two(mention)
            case MentionKind.BOTH:
                return self._both(mention)
            case MentionKind.OTHER:
                return self._but(focus.vehicles)
            case MentionKind.POSSESSIVE:
                owner = here if here.vehicles else self.last if self.last.span.end else focus
                strikes = self.clause is not None and self.clause.kind in STRIKES and not self.clause.is_passive
                if (
                    strikes
                    and self.clause is not None
                    and self.clause.object is None
                    and not is_apart(self.clause.tail, ",;")
                ):
                    return self._but(owner.vehicles) or owner.vehicles[:1]  # "its nose went under its bumper"
                is_self = bool(self.writer) and owner.vehicles == self.writer and self.writer[0] not in self.genders
                return self._latest_other() if is_self and mention.is_person else owner.vehicles[:1]
            case MentionKind.ONE if self.items[mention.first].low == "they" and self._meets(mention.last + 1):
                return self._both(mention)
            case MentionKind.IT | MentionKind.ONE | MentionKind.PERSON if not mention.is_new:
                return self._pronoun(mention, here, focus)
        return ()

    def _meets(self, place: int) -> bool:
        """Whether a verb of meeting follows."""
        verbs = [item.verb for item in self.items.cut(place, place + 3) if item.verb is not None]
        return bool(verbs) and verbs[0].kind in {"collide", *STRIKES}

    def _but(self, vehicles: Sequence[int]) -> tuple[int, ...]:
        """The other one of the first two."""
        rest = [each for each in range(min(self.count, 2)) if each not in vehicles]
        return (rest[0],) if len(rest) == 1 else ()

    def _of_two(self, mention: Mention) -> tuple[int, ...]:
        """The former or the latter of the last two."""
        last = list(dict.fromkeys(reversed(self.recent)))
        at = 0 if self.items[mention.first].get("pronoun") == "latter" else 1
        return (last[at],) if at < len(last) else ()

    def _both(self, mention: Mention) -> tuple[int, ...]:
        """The vehicles that "both" or "they all" mean: of more than two, the last that have done something."""
        if self.count <= 2 or "all" in self.items[mention.first].low:
            return tuple(range(min(self.count, 3)))
        subjects = [*(each.subject for each in self.clauses), self.pending or NOBODY]
        done = [each.vehicles[0] for each in subjects if each.vehicles]
        is_they = self.items[mention.first].low == "they" and bool(self.own)
        ranked = list(dict.fromkeys([*reversed(done), *range(self.count)]))
        return tuple(sorted(sorted(ranked, key=lambda each: is_they and each == self.own[0])[:2]))

    def _pronoun(self, mention: Mention, here: Actor, focus: Actor) -> tuple[int, ...]:
        before, after = self.items.at(mention.first - 1), self.items.at(mention.last + 1)
        is_it = mention.kind is MentionKind.IT
        if is_it and mention.last > mention.first and after.is_a("ahead", "behind"):
            return ()  # "the vehicle in front of him"
        if (before.is_a("ahead", "behind", "beside") or before.low in word_set("towards")) and here.span.end:
            return next(((each,) for each in reversed(self.recent) if each not in here.vehicles), ())
        if before.low == "of" and self.items.at(mention.first - 2).is_a("part") and here.vehicles:
            return next(
                ((each,) for each in reversed(self.recent) if each not in here.vehicles), ()
            )  # "the back of it"
        is_object = self.clause is not None and self.clause.kind in _OTHERS_OBJECT
        word = self.items[mention.first].low
        is_object |= word in {"him", "them"} and bool(here.vehicles) and self.clause is not None
        is_object &= word not in word_set("subject_pronouns")
        if self.clause is not None and is_object and here.span.end and not is_apart(self.clause.tail, ",;"):
            is_known = bool(self.last.span.end) and self.last.vehicles != here.vehicles
            return self.last.vehicles if is_known else self._but(here.vehicles)
        is_mine = bool(self.writer) and focus.is_person and focus.vehicles == self.writer
        if is_it and is_mine and self.thing.vehicles and mention.kind is MentionKind.IT:
            return self.thing.vehicles[:1]  # "I supposed it was parked"
        if is_it and here.is_person and not self.last.is_person and self.last.vehicles:
            return self.last.vehicles[:1]  # "I did not see the van until it hit me"
        found = focus.vehicles or self.last.vehicles
        if (
            found
            and mention.kind is MentionKind.ONE
            and found == self.writer
            and focus.is_person
            and found[0] not in self.genders
        ):
            return self._latest_other()  # nobody calls himself "he"
        if mention.kind is MentionKind.ONE and not (found or self.own or self.recent) and self.count:
            return (0,)  # who is told of before a name is given
        return found if mention.kind is MentionKind.ONE and len(found) > 1 else found[:1]

    def _latest_other(self) -> tuple[int, ...]:
        """The vehicle that was spoken of last and is not the writer's."""
        return next(((each,) for each in reversed(self.recent) if (each,) != self.own), self._but(self.own))


def is_apart(words: Words, marks: str) -> bool:
    """Whether a conjunction or one of some marks stands among words."""
    return any(item.is_a("conjunction") or item.low in marks for item in words)
