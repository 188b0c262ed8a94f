"""Clauses read from the trees of sentences: each verb with its subject, its object, and what prepositions bring in."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from roadmend.safe.claims import Span
from roadmend.safe.reading.clauses import NOBODY, STRIKES, Actor, Clause
from roadmend.safe.reading.groups import NounGroup
from roadmend.safe.reading.lexicon import VerbSense, word_set
from roadmend.safe.reading.mentions import Spoken
from roadmend.safe.reading.referents import Ranking, Referents, Role
from roadmend.safe.reading.structure import SUBJECTS, Structure
from roadmend.safe.reading.syntax import Tree
from roadmend.safe.reading.tokens import Item, Sentence, Words

_OBJECTS = ("dobj", "obj", "dative", "oprd")
_OF_DRIVERS = frozenset({"intend", "see", "slow", "emerge", "overtake", "follow", "reverse", "uturn", "change_lane"})
_ROADS_DO = frozenset({"join", "merge", "enter"})
_NEAR = 3  # words
_ADVERBS = ("ward", "wards")
_COMES = frozenset({"travel", "emerge", "stop", "follow", "approach"})
_GOVERNING = frozenset({"intend", "begin", "avoid", "fail", "see", "say", "do", "stop", "slow", "park"})


def read_clauses(
    structures: Sequence[Structure], spoken: Spoken, picks: Mapping[int, int] | None = None
) -> tuple[tuple[Clause, ...], list[Ranking]]:
    """The clauses of a text in its order, and the mentions that may be of several vehicles.

    Args:
        structures: of its sentences.
        spoken: its vehicles and where it speaks of them.
        picks: which vehicles open mentions are taken for, where not for the likeliest.
    """
    own = spoken.roll.own()
    firsts = (each.items[row.first] for each, rows in zip(structures, spoken.mentions, strict=True) for row in rows)
    speaks = any(item.get("pronoun") in {"self", "own"} for item in firsts)
    people = {name: each.place for each in spoken.roll.vehicles for name in each.people}
    referents = Referents(len(spoken.roll.vehicles), own, speaks, people, picks or {})
    clauses: list[Clause] = []
    for structure in structures:
        clauses += _SentenceReader(structure, referents).read()
    return tuple(clauses), referents.rankings


@dataclass(slots=True)
class _SentenceReader:
    """Makes the clauses of one sentence."""

    structure: Structure
    referents: Referents
    actors: dict[int, Actor] = field(default_factory=dict)  # by a group's first word
    made: dict[int, Clause] = field(default_factory=dict)  # by predicate
    busy: set[int] = field(default_factory=set)

    def read(self) -> list[Clause]:
        """The clauses in the order of their verbs; what has none comes where it stands."""
        verbs = [at for at in range(len(self.items)) if self._is_predicate(at)]
        found = []
        for at in verbs:
            clause = self._clause(at)
            if clause is not None:
                found.append(clause)
                self.referents.walks |= any(
                    item.is_a("walker") and item.get("walker") != "animal" for item in clause.words
                )
                if clause.subject.vehicles:
                    self.referents.focus = clause.subject
        return sorted([*found, *self._verbless()], key=lambda each: each.span.end)

    @property
    def sentence(self) -> Sentence:
        return self.structure.sentence

    @property
    def items(self) -> Words:
        return self.structure.items

    @property
    def tree(self) -> Tree:
        return self.structure.tree

    @property
    def groups(self) -> Sequence[NounGroup]:
        return self.structure.groups

    def _group(self, at: int) -> NounGroup | None:
        return self.structure.group(at)

    def _owner(self, at: int) -> int | None:
        return self.structure.owner(at)

    def _is_predicate(self, at: int) -> bool:
        return self.structure.is_predicate(at)

    def _is_trait(self, place: int, subject: Actor) -> bool:
        """Whether "southbound" stands right behind another vehicle's name: "yielded to V2 (a Ford) southbound"."""
        if not self.items[place].is_a("bound") or self.items[place].low.endswith(_ADVERBS):
            return False
        back = place - 1
        while back > 0 and self.items[back].low in {")", "("}:
            back -= 1
        group = self._group(back)
        actor = self.actors.get(group.first) if group is not None and group.part is None else None
        return actor is not None and bool(actor.vehicles) and actor.vehicles != subject.vehicles

    def _next(self, at: int, clause: Clause) -> Actor | None:
        """Who is named right behind a verb of contact, where the parser gave it no object."""
        group = next((each for each in self.groups if at < each.first <= at + _NEAR), None)
        if group is None or self._lead(group) is not None:
            return None
        if any(actor.span.start == self.items[group.first].span.start for _, actor in clause.others):
            return None
        apart = any(
            self.items[each].is_a("conjunction") or self.items[each].low in ",;" for each in range(at + 1, group.first)
        )
        return None if apart else self._joined(group, Role.OBJECT, clause)

    def _lead(self, group: NounGroup) -> Item | None:
        return self.structure.lead(group)

    # ------------------------------------------------------------------------------------------------ clauses

    def _clause(self, at: int) -> Clause | None:
        if at in self.made:
            return self.made[at]
        if at in self.busy:
            return None
        self.busy.add(at)
        verb = self._verb(at)
        subject, governed = self._subject(at)
        clause = Clause(self.sentence, subject, verb, governed=governed)
        self.made[at] = clause
        clause.is_passive = self._is_passive(at)
        clause.is_denied = self._is_denied(at)
        head = self._head_group(at)
        for group in self.groups:
            if self._owner(group.top) == at and group.first not in self.actors:
                self._bring(at, clause, group)
        if head is not None and clause.object is None and subject.span != self._actor(head, Role.OTHER).span:
            clause.object = self._actor(head, Role.OBJECT, subject, clause.kind)
        if clause.object is None and not clause.is_passive and clause.kind in STRIKES | {"collide"}:
            clause.object = self._next(at, clause)
        mine = [
            place
            for place in range(len(self.items))
            if place != at and self._group(place) is None and self._owner(place) == at
            if not self._is_trait(place, subject)
        ]
        if verb is None:
            clause.head = Words(self.items[place] for place in sorted([*mine, at]))
        else:
            clause.head = Words(self.items[place] for place in mine if place < at)
            clause.tail = Words(self.items[place] for place in mine if place > at)
        starts = [self.items[at].span.start]
        if subject.span.end and subject.span.start >= self.sentence.span.start:
            starts.append(subject.span.start)
        clause.span = Span(min(starts), max(self.items[at].span.end, subject.span.end if len(starts) > 1 else 0))
        return clause

    def _verb(self, at: int) -> VerbSense | None:
        """The verb at a place; "went to" is a way to go where no other verb follows."""
        verb = self.items[at].verb
        goes = verb is not None and verb.kind == "intend" and verb.lemma == "go"
        return replace(verb, kind="travel") if verb and goes and not self.tree.has(at, "xcomp") else verb

    def _subject(self, at: int) -> tuple[Actor, frozenset[str]]:
        """Who does what a predicate says, and the kinds of the verbs that it depends on."""
        arc, verb = self.tree[at], self.items[at].verb
        kind = verb.kind if verb is not None else ""
        governed = self._governed(at)
        for child in self.tree.children(at, *SUBJECTS):
            if self.items[child].is_a("relative") and arc.relation in {"relcl", "acl"}:
                return self._described(self._antecedent(child, arc.head)), governed
            if self._is_weather(child, at):
                return NOBODY, governed
            if self.items[child].low in {"it", "which"} and self.referents.is_road:
                return NOBODY, governed  # what a road does
            if self._is_drivers(at, child):
                return self._before(at), governed
            behind = next((each for each in self.tree.children(at, "attr") if self._group(each) is not None), None)
            is_thing = self._group(child) is None and not self.items[child].is_a("pronoun")
            is_thing |= self.items[child].low == "it" and behind is not None and self._is_new(behind)
            if is_thing and behind is not None and self.tree[at].tag == "AUX":
                return self._named(behind, Role.SUBJECT, kind), governed  # "Oncoming was a van", "It was a van"
            self.referents.is_road = self._group(child) is None and self._is_road(child)
            return self._named(child, Role.SUBJECT, kind), governed
        if arc.relation in {"relcl", "acl"}:
            return self._described(arc.head), governed
        if kind in STRIKES and (driven := self._before_aside(at)) is not None:
            return driven, governed
        beside = next((each for each in self.groups if each.last == at - 1), None)
        if kind in STRIKES and beside is not None and self._lead(beside) is None:
            return self._actor(beside, Role.SUBJECT), governed
        up = next((each for each in self.tree.chain(at) if self._is_predicate(each)), None)
        if up is not None:
            above = self._clause(up)
            if above is None:
                return self.referents.focus, governed
            if arc.relation == "xcomp" and above.object is not None and above.kind not in _GOVERNING - {"see"}:
                return above.object, governed
            if not above.subject.vehicles and kind in _OF_DRIVERS | STRIKES | {"turn"}:
                higher = (self._clause(each) for each in self.tree.chain(up) if self._is_predicate(each))
                found = next((each.subject for each in higher if each is not None and each.subject.vehicles), None)
                return found or above.subject, governed  # "on a street that ends there and turned left"
            return above.subject, governed
        behind = next(iter(self.tree.children(at, "attr", "dobj")), None)
        comes = kind in _COMES and verb is not None and verb.lemma not in {"drive", "operate"}
        if (
            behind is not None
            and self._group(behind) is not None
            and (self.tree[at].tag == "AUX" or comes or self.items[at].low == "theres")
        ):
            return self._named(behind, Role.SUBJECT, kind), governed  # "To my right was a van", "Out rolls a van"
        return self._before(at), governed

    def _before_aside(self, at: int) -> Actor | None:
        """Who does what stands behind an aside in commas: "Jones, driving a Ford, struck him"."""
        opened = next((place for place in range(at - 2, 0, -1) if self.items[place].low == ","), 0)
        if self.items.at(at - 1).low != "," or not opened:
            return None
        verb = self.items[opened + 1].verb
        inside = (each for each in self.groups if opened < each.first and each.last < at and each.mention is not None)
        group = self._group(opened - 1) or (next(inside, None) if verb is not None and verb.form == "ing" else None)
        return self._actor(group, Role.SUBJECT) if group is not None and self._lead(group) is None else None

    def _antecedent(self, relative: int, head: int) -> int:
        """The head of whom "which" and "who" speak: the group right before it, whatever the parser hung it to."""
        at = relative - 1
        while self.items.at(at).low in {",", ")"}:
            at -= 1
        group = self._group(at)
        return head if group is None else group.top

    def _is_drivers(self, at: int, child: int) -> bool:
        """Whether only who drives can do what a verb says, and its subject is nobody who could: the parser erred."""
        verb, item = self.items[at].verb, self.items[child]
        if verb is None or self._group(child) is not None or item.low in self.referents.people:
            return False
        if item.is_a("person", "relative", "pronoun", "walker"):
            return False
        turns = verb.kind == "turn" and not self._is_road(child) and not item.is_a("signal", "part")
        place = item.is_a("signal", "road", "lane", "junction", "curve", "time")
        turns |= verb.kind in STRIKES and place  # "heading through the light hit its side"
        return turns or (verb.kind in _OF_DRIVERS and verb.lemma not in _ROADS_DO)

    def _before(self, at: int) -> Actor:
        """Who is named before a verb whose subject the parser did not find; else who was spoken of before."""
        group = next((each for each in reversed(self.groups) if each.last < at and self._lead(each) is None), None)
        if group is None or group.is_place or any(self._is_predicate(each) for each in range(group.last + 1, at)):
            return self.referents.focus
        return self._actor(group, Role.SUBJECT)

    def _described(self, place: int) -> Actor:
        """Who a relative clause speaks of: the vehicle that it hangs on, or that has what it hangs on: "with a trailer that"."""
        group = self._group(place) or self.structure.within(place)
        return replace(self._actor(group, Role.OTHER), part=None) if group is not None else NOBODY

    def _is_road(self, place: int) -> bool:
        """Whether a word is a road's, or a name that no table knows and no vehicle has."""
        item = self.items[place]
        return item.is_a("road", "lane", "junction", "ramp", "curve", "driveway") or (item.is_name and not item.kinds)

    def _is_new(self, place: int) -> bool:
        """Whether a vehicle is named of which the text did not speak before."""
        group = self._group(place)
        return group is not None and group.mention is not None and group.mention.is_new

    def _is_weather(self, subject: int, at: int) -> bool:
        """Whether "it" stands for nothing: "it was dark", "it was raining"."""
        if self.items[subject].low != "it" or self.items.at(at).is_a("verb"):
            return False
        told = self.items.cut(at, at + 6)
        return told.has("time", "weather") and not told.has("bound", "lane")

    def _governed(self, at: int) -> frozenset[str]:
        found: set[str] = set()
        place = at
        for up in self.tree.chain(at):
            arc = self.tree[place]
            if not self._is_predicate(up):
                place = up
                continue
            verb = self.items[up].verb
            linked = arc.relation in {"xcomp", "pcomp", "ccomp", "conj"} or (
                arc.relation == "advcl" and not self.tree.has(at, *SUBJECTS, "mark")
            )
            if not linked or (arc.relation == "ccomp" and (verb is None or verb.kind != "begin")):
                break
            if verb is not None and verb.kind in _GOVERNING and arc.relation != "conj":
                found.add(verb.kind)
                if self._is_denied(up) and verb.kind in {"intend", "begin", "do"}:
                    found.add("avoid")
                if verb.kind == "avoid" and (self._is_denied(up) or "fail" in self._governed(up)):
                    found.discard("avoid")
            mine = self.items[at].verb
            if arc.relation == "conj" and mine is not None and (verb is None or verb.form != mine.form):
                break
            place = up
        return frozenset(found)

    def _is_passive(self, at: int) -> bool:
        verb = self.items[at].verb
        if self.tree.has(at, "auxpass", "nsubjpass", "agent"):
            return True
        if self.tree.has(at, "dobj", "obj"):
            return False  # "and struck him": what is done to somebody else
        reduced = self.tree[at].relation == "acl" and verb is not None and verb.form in {"both", "participle"}
        if reduced:
            return True
        after = self.items.at(at + 1)
        by = verb is not None and verb.kind in STRIKES and after.low == "by"
        conj = self.tree[at].relation == "conj" and verb is not None and verb.form in {"both", "participle"}
        up = self.tree[at].head
        shared = conj and up in self.made and self.made[up].is_passive and not self.tree.has(at, *SUBJECTS, "aux")
        return by or shared

    def _is_denied(self, at: int) -> bool:
        verb, near = self.items[at].verb, self.items.cut(at - 3, at)
        denies = any(
            (self.tree[each].relation == "neg" and self._group(each) is None) or self.items[each].is_a("negation")
            for each in self.tree.children(at, "aux", "advmod", "auxpass", "neg")
        )
        if denies and (verb is None or verb.kind != "fail"):
            return True
        missed = near.at(len(near) - 1).low in word_set("near_misses") or (
            near.cut(len(near) - 2).says({"would", "could", "might"}) and near.at(len(near) - 1).low == "have"
        )
        if missed and verb is not None and verb.kind in STRIKES | {"collide"}:
            return True
        marks = {self.items[each].low for each in self.tree.children(at, "mark")}
        if "if" in marks and near.says({"as"}):
            return True
        return self.tree[at].relation == "pcomp" and self.items[self.tree[at].head].low in {"without", "instead of"}

    def _head_group(self, at: int) -> NounGroup | None:
        """The noun that a relative clause says something of, where it is not its subject: "the car that V1 struck"."""
        arc = self.tree[at]
        if arc.relation != "relcl":
            return None
        relative = [child for child in self.tree.children(at, *SUBJECTS) if self.items[child].is_a("relative")]
        has_subject = self.tree.has(at, *SUBJECTS) and not relative
        return self._group(arc.head) if has_subject else None

    # ----------------------------------------------------------------------------------------- noun groups

    def _named(self, place: int, role: Role, kind: str) -> Actor:
        """The actor at a place, with those that "and" joins to it; nobody where no vehicle is named there."""
        beside = (self._group(each) for each in self.tree.children(place, "appos"))  # "the third, a semi, hit it"
        group = self._group(place) or self.structure.within(place) or next(filter(None, beside), None)
        if group is None and self.items[place].low in self.referents.people:
            vehicle = self.referents.people[self.items[place].low]
            self.referents.recent.append(vehicle)
            return Actor((vehicle,), None, is_person=True, span=self.items[place].span)
        if group is None:
            return replace(NOBODY, span=self.items[place].span)
        return self._together(self.structure.joined(group), role, NOBODY, kind)

    def _together(self, groups: Iterable[NounGroup], role: Role, subject: Actor, kind: str) -> Actor:
        """One actor of all that some noun groups, at least one, name."""
        first, *rest = (self._actor(group, role, subject, kind) for group in groups)
        if not rest:
            return first
        vehicles = tuple(dict.fromkeys(vehicle for each in (first, *rest) for vehicle in each.vehicles))
        return Actor(vehicles, None, first.is_person, Span(first.span.start, rest[-1].span.end))

    def _actor(self, group: NounGroup, role: Role, subject: Actor = NOBODY, kind: str = "") -> Actor:
        if group.first in self.actors:
            return self.actors[group.first]
        if group.mention is None:
            actor = Actor((), group.part, is_person=False, span=self.items.span(group.first, group.last))
        else:
            actor = self.referents.resolve(group.mention, self.items, role, subject, kind)
            if group.part is not None:
                span = self.items.span(group.first, group.last)
                actor = replace(actor, part=group.part, is_person=False, span=span)
            elif group.is_place:
                actor = replace(actor, vehicles=())
        self.actors[group.first] = actor
        return actor

    def _bring(self, at: int, clause: Clause, group: NounGroup) -> None:
        """Give a noun group its part in a clause."""
        arc = self.tree[group.top]
        is_object = arc.head == at and (
            arc.relation in _OBJECTS or (arc.relation == "pobj" and clause.verb is not None)
        )
        if is_object and clause.object is None and not clause.is_passive:
            clause.object = self._joined(group, Role.OBJECT, clause)
            return
        lead = self._lead(group)
        if lead is not None:
            role = Role.TOOL if lead.low == "with" else Role.OTHER
            clause.others.append((lead, self._joined(group, role, clause)))
        elif arc.relation not in {"conj", "appos"}:
            self._actor(group, Role.OTHER, clause.subject, clause.kind)

    def _joined(self, group: NounGroup, role: Role, clause: Clause) -> Actor:
        kind = "" if clause.is_passive else clause.kind
        groups = (each for each in self.structure.joined(group) if each is group or each.first not in self.actors)
        return self._together(groups, role, clause.subject, kind)

    def _verbless(self) -> Iterator[Clause]:
        """What has no verb: "V1 northbound on Main Street, V2 southbound"."""
        free = [at for at in range(len(self.items)) if self._owner(at) is None]
        runs: list[list[int]] = []
        for at in free:
            group = self._group(at)
            begins = group is not None and group.first == at and self._lead(group) is None
            if not runs or begins or runs[-1][-1] < at - 1 or self.items[at].low == ";":
                runs.append([])
            runs[-1].append(at)
        for places in runs:
            yield from self._of_run(places)

    def _of_run(self, places: Sequence[int]) -> Iterator[Clause]:
        inside = [each for each in self.groups if each.first in places and each.first not in self.actors]
        if inside and self._lead(inside[0]) is None:
            subject, inside = self._actor(inside[0], Role.SUBJECT), inside[1:]
        else:
            subject = self.referents.focus
        clause = Clause(self.sentence, subject, None)
        for group in inside:
            self._bring(-1, clause, group)
        clause.head = Words(self.items[at] for at in places if self._group(at) is None)
        end = self.items[places[-1]].span.end
        clause.span = Span(min(self.items[places[0]].span.start, end), end)
        if clause.head or clause.others or subject.part is not None:
            yield clause
            self.referents.focus = subject if subject.vehicles else self.referents.focus
