"""Where a text speaks of vehicles and of those who drive them, and which vehicle each time, as far as names tell."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from roadmend.safe.dsl import DslModel
from roadmend.safe.reading.cast import Description, MentionedVehicle, VehicleRoll, shares_name
from roadmend.safe.reading.clauses import STRIKES
from roadmend.safe.reading.naming import Mention, MentionKind
from roadmend.safe.reading.seats import PEOPLE, Seats, seats_of
from roadmend.safe.reading.structure import SUBJECTS, Structure

_DRIVES = frozenset(
    {"travel", "turn", "stop", "slow", "emerge", "approach", "continue", "overtake", "follow", "change_lane", "reverse"}
)
_HEADLINE, _OPENING = 16, 3  # words
_MEMORY = 3  # sentences after which somebody without a vehicle is forgotten
_SAME_NAME, _SAME_BODY, _SAME_WORDS, _SAME_MARK = 6.0, 1.5, 1.0, 2.0  # [nats] for a vehicle that was spoken of before
_NAMED_NOW = 1.0  # one that had no name gets it
_TOLD_AGAIN = 3.0  # a headline or a lead told of it without a name
_DEFINITE, _INDEFINITE, _LATEST = 1.0, -3.0, 0.5
_NOBODYS = 0.4  # "the Civic" of which nothing was said may be the writer's
_OTHER = -5.0  # "the other one" is not the last


@dataclass(slots=True)
class Spoken:
    """The vehicles of a text and where it speaks of them, by sentence."""

    roll: VehicleRoll = field(default_factory=VehicleRoll)
    mentions: Sequence[Sequence[Mention]] = ()


def find_vehicles(structures: Sequence[Structure], found: Sequence[Sequence[Mention]]) -> Spoken:
    """Tell the vehicles of a text apart, and which of them each name and each person with a vehicle is.

    Args:
        structures: of its sentences.
        found: mentions of each sentence; gets the vehicles filled in.
    """
    casting = _Casting(structures, found)
    casting.cast()
    return Spoken(VehicleRoll(casting.vehicles), found)


@dataclass(slots=True)
class _Casting:
    """Goes through a text and gathers its vehicles."""

    structures: Sequence[Structure]
    found: Sequence[Sequence[Mention]]
    seats: Seats = field(default_factory=Seats)
    vehicles: list[MentionedVehicle] = field(default_factory=list)
    people: dict[str, MentionedVehicle] = field(default_factory=dict)
    waiting: list[tuple[int, Mention]] = field(default_factory=list)  # people without a vehicle so far, by sentence
    own: MentionedVehicle | None = None
    is_own_told: bool = False  # whether the text says somewhere what the writer drives
    latest: MentionedVehicle | None = None

    def cast(self) -> None:
        self._enrol()  # first, for it tells which numbers are the report's
        self.seats = seats_of(self.structures, self.found)
        titles = [self._is_headline(place) for place in range(len(self.structures))]
        is_drawn = any(
            each.description for row, title in zip(self.found, titles, strict=True) if not title for each in row
        )
        titles = [title and is_drawn for title in titles]
        self._find_writer()
        for is_title in (False, True):
            for at, row in enumerate(self.found):
                for mention in row if titles[at] is is_title else ():
                    vehicle = self._of(at, mention, is_title=is_title)
                    if vehicle is not None:
                        self._note(at, mention, vehicle, is_title=is_title)
        self._drop_witness()
        self._be_two()
        self._lead_in()
        self._describe_alike()
        self._put_in_order()

    def _enrol(self) -> None:
        """Make places for the vehicles that the text numbers, with all that it says of them beside their numbers."""
        named = [each for row in self.found for each in row if each.number is not None and each.description is not None]
        numbers = sorted({each.number for each in named if each.number is not None})
        if len(numbers) == 1 and numbers[0] > 1:  # "Truck 4" is no report's number
            for mention in named:
                described = mention.description or Description()
                is_told = described.names or described.bodies
                mention.description = replace(described, number=None) if is_told else None
            return
        for number in numbers:
            mine = [each.description for each in named if each.number == number and each.description is not None]
            vehicle = MentionedVehicle(len(self.vehicles), Description(number=number))
            for described in mine:
                if described.names or described.bodies:
                    vehicle.description = vehicle.description.merged(described)
            self.vehicles.append(vehicle)

    # --------------------------------------------------------------------------------------------- the writer

    def _find_writer(self) -> None:
        """Make a place for the writer's vehicle, where the writer drives one."""
        mine = [each.description for row in self.found for each in row if each.description and each.description.is_own]
        self.is_own_told = any(each.names or each.bodies for each in mine)
        if mine:
            drives = True
        else:
            drives = any(
                self._drives(structure, mention)
                for structure, row in zip(self.structures, self.found, strict=True)
                for mention in row
            )
        speaks = any(
            each.kind is MentionKind.SELF and each.speaker is None and not each.vehicles
            for row in self.found
            for each in row
        )
        numbered = {each.number for each in mine} & {each.description.number for each in self.vehicles} - {None}
        if numbered:  # "vehicle A (me)"
            self.own = next(each for each in self.vehicles if each.description.number in numbered)
            self.own.description = replace(self.own.description, is_own=True)
        elif drives and (speaks or mine):
            self.own = MentionedVehicle(len(self.vehicles), Description(is_own=True, words=""))
            self.vehicles.append(self.own)

    def _drives(self, structure: Structure, mention: Mention) -> bool:
        """Whether "I" drive, or am struck."""
        if mention.kind is not MentionKind.SELF or mention.speaker is not None:
            return False
        if id(mention) in self.seats.partner:
            return True
        group = next((each for each in structure.groups if each.mention is mention), None)
        at = structure.owner(group.top) if group is not None else None
        if group is None or at is None:
            return False
        verb, arc = structure.items[at].verb, structure.tree[group.top]
        does = arc.relation in {"nsubj", "conj"} and structure.subject(at) is group
        around = structure.items.cut(at - 2, at + 8)
        if verb is None:
            return does and around.has("bound", "lane")
        is_struck = arc.head == at and arc.relation in {"dobj", "nsubjpass", "pobj"} and verb.kind in STRIKES
        on_road = around.has(
            "bound", "lane", "road", "junction", "signal", "stop_sign", "hand", "compass", "behind", "ahead"
        )
        return is_struck or (does and verb.kind in _DRIVES | STRIKES and (on_road or verb.kind in STRIKES))

    # ------------------------------------------------------------------------------------- one mention at a time

    def _of(self, at: int, mention: Mention, *, is_title: bool) -> MentionedVehicle | None:
        """The vehicle of a mention; None while that is open."""
        if mention.vehicles:
            return self.vehicles[mention.vehicles[0]]
        if mention.twin is not None and mention.twin.vehicles:
            return self.vehicles[mention.twin.vehicles[0]]
        if mention.number is not None:
            return next(each for each in self.vehicles if each.description.number == mention.number)
        if mention.speaker is not None:
            number = mention.speaker.number
            return next((each for each in self.vehicles if each.description.number == number), None)
        described = mention.description
        if self.own is not None and (mention.kind is MentionKind.SELF or (described is not None and described.is_own)):
            return self.own
        seat = self.seats.partner.get(id(mention))
        if seat is not None and seat.vehicles:
            return self.vehicles[seat.vehicles[0]]
        if seat is not None and seat.kind is MentionKind.SELF and self.own is not None:
            return self.own
        if seat is not None and seat.description is not None and described is None:
            return self._of(at, seat, is_title=is_title)
        if described is not None:
            return self._described(at, mention, described, is_title=is_title)
        if mention.kind is MentionKind.PERSON:
            known = self.people.get(_called(self.structures[at], mention))
            if known is not None and not mention.is_new:
                return known
        if mention.kind in PEOPLE:
            self.waiting.append((at, mention))
        return None

    def _described(
        self, at: int, mention: Mention, described: Description, *, is_title: bool
    ) -> MentionedVehicle | None:
        weights = {id(each): self._weight(each, at, mention, described, is_title=is_title) for each in self.vehicles}
        best = max(self.vehicles, key=lambda each: weights[id(each)], default=None)
        is_towed = best is not None and best.description.body()[0] in {DslModel.SEMI_TRUCK, DslModel.PICKUP, None}
        if best is not None and weights[id(best)] > 0 and (is_towed or described.words != "trailer"):
            return best
        if described.words == "trailer" or (is_title and best is not None):
            return None
        vehicle = MentionedVehicle(len(self.vehicles), described)
        self.vehicles.append(vehicle)
        if described.is_theirs:
            self._settle(at, vehicle)
        return vehicle

    def _weight(
        self, vehicle: MentionedVehicle, at: int, mention: Mention, described: Description, *, is_title: bool
    ) -> float:
        """What speaks for a vehicle that was spoken of before, against a new one [nats]."""
        known = vehicle.description
        if known.is_own and not vehicle.is_known:
            article = self.structures[at].items[mention.first]
            is_first = mention.is_new or article.get("determiner") != "the" or article.low in {"this", "these"}
            return _NOBODYS if not is_first and not self.is_own_told and not described.is_other else -1.0
        if known.contradicts(described) or (known.number is not None and not vehicle.is_known and not described.names):
            return -9.0
        colours = known.marks & described.marks
        ways = {each.get("bound") for each in mention.traits} - {None}
        if (known.marks and described.marks and not colours) or (ways and vehicle.ways and not ways & vehicle.ways):
            return -9.0
        same = shares_name(known, described)
        if described.names and known.names and not same:
            return -9.0
        told = _SAME_NAME * same + _SAME_MARK * bool(colours)
        body = described.body()[0]
        if body is not None and known.body()[0] is body:
            told += _SAME_BODY
        alike = described.words and any(
            described.words in words or words in described.words for words in vehicle.words if words
        )
        told += _SAME_WORDS * bool(alike)
        if (described.names and not known.names) or (described.bodies and not vehicle.is_known):
            told += _NAMED_NOW
        lead = vehicle.latest < at and not known.is_own and (vehicle.is_headline or self._is_lead(vehicle))
        news = bool(described.names) or not vehicle.is_known or vehicle.is_headline
        rest = self.structures[at].sentence.paragraph > self.structures[vehicle.latest].sentence.paragraph
        news |= body is not None and known.body()[0] is body and rest and len(self.vehicles) > 1
        told += _TOLD_AGAIN * (lead and not known.names and news)
        numbered = [each for each in self.vehicles if each.description.number is not None]
        if known.number is not None and not vehicle.is_known and sum(not each.is_known for each in numbered) == 1:
            told += _TOLD_AGAIN
        told += _INDEFINITE if mention.is_new and not is_title else _DEFINITE
        told += _LATEST * (vehicle is self.latest)
        if described.is_other and (vehicle is self.latest or known.is_own):
            told += _OTHER
        if not vehicle.is_known and known.number is None and not known.is_own:
            told += 1.0
        if body is None and not described.names and not known.names:
            told -= 0.5
        return told

    def _is_lead(self, vehicle: MentionedVehicle) -> bool:
        """Whether only the first sentences, which tell all in short, have spoken of a vehicle that has no name."""
        if self.own is not None or any(each.description.number for each in self.vehicles):
            return False
        first = next((at for at, row in enumerate(self.found) if any(each.description for each in row)), 0)
        return vehicle.latest <= first + self._is_headline(first)

    def _settle(self, at: int, vehicle: MentionedVehicle) -> None:
        """Let somebody who waits for a vehicle have one that is called hers or his."""
        waiting = [(place, each) for place, each in self.waiting if at - place < _MEMORY and not each.vehicles]
        people = [each for each in waiting if each[1].kind is not MentionKind.ONE] or waiting
        if people:
            place, person = people[-1]
            self._note(place, person, vehicle, is_title=False)

    def _note(self, at: int, mention: Mention, vehicle: MentionedVehicle, *, is_title: bool) -> None:
        """Remember that a mention is of a vehicle."""
        mention.vehicles = (vehicle.place,)
        if mention.description is not None:
            if mention.description is not vehicle.description:
                own = replace(mention.description, is_other=False, is_own=False, number=None)
                vehicle.description = vehicle.description.merged(own)
            vehicle.words.append(mention.description.words)
            vehicle.ways |= {each.get("bound") for each in mention.traits} - {None}
        if mention.is_person or mention.kind is MentionKind.PERSON:
            name = _called(self.structures[at], mention)
            vehicle.people |= {name} if name else set()
            if name:
                self.people.setdefault(name, vehicle)
            if not mention.is_new:
                self._backfill(at, mention, vehicle)
        if not is_title:
            start = mention.span.start
            vehicle.first = start if vehicle.first is None else min(vehicle.first, start)
            self.latest = vehicle
        vehicle.is_headline = is_title if vehicle.first is None else False
        vehicle.latest = max(vehicle.latest, at)
        if id(mention) in self.seats.named:
            self.people.setdefault(self.seats.named[id(mention)], vehicle)
            vehicle.people.add(self.seats.named[id(mention)])
        seat = self.seats.partner.get(id(mention))
        if seat is not None and not seat.vehicles:
            self._note(at, seat, vehicle, is_title=is_title)

    def _backfill(self, at: int, mention: Mention, vehicle: MentionedVehicle) -> None:
        """Let "a driver" of whom the text spoke before be the one who now turns out to sit in a vehicle."""
        early = [each for each in self.waiting if each[1].kind is MentionKind.PERSON and not each[1].vehicles]
        early = [each for each in early if each[1].is_new and each[1].span.start < mention.span.start]
        early = [each for each in early if _is_somebody(self.structures[each[0]], each[1])]
        if len(early) == 1 and at - early[0][0] <= _MEMORY:
            early[0][1].vehicles = (vehicle.place,)
            start = early[0][1].span.start
            vehicle.first = start if vehicle.first is None else min(vehicle.first, start)

    # -------------------------------------------------------------------------------------------- the whole

    def _is_headline(self, at: int) -> bool:
        """Whether a sentence stands alone over a text, as a newspaper's headline does."""
        sentence = self.structures[at].sentence
        alone = sum(each.sentence.paragraph == sentence.paragraph for each in self.structures) == 1
        return alone and sentence.paragraph == 0 and len(sentence.items) < _HEADLINE and len(self.structures) > 1

    def _drop_witness(self) -> None:
        """Who drives by and is neither struck nor strikes has no part in a crash of two others."""
        others = [each for each in self.vehicles if each is not self.own and each.is_known]
        if self.own is None or self.own.is_known or self.own.description.number or len(others) < 2 or self._is_in_it():
            return
        gone = self.own.place
        self.vehicles = [each for each in self.vehicles if each is not self.own]
        self.own = None
        for at, vehicle in enumerate(self.vehicles):
            vehicle.place = at
        for mention in (each for row in self.found for each in row):
            mention.vehicles = tuple(each - (each > gone) for each in mention.vehicles if each != gone)

    def _is_in_it(self) -> bool:
        """Whether the writer, or a part of the writer's vehicle, touches anything."""
        for structure in self.structures:
            for group in structure.groups:
                mention = group.mention
                mine = mention is not None and (
                    mention.kind is MentionKind.SELF or bool(mention.description and mention.description.is_own)
                )
                at = structure.owner(group.top) if mine else None
                verb = structure.items[at].verb if at is not None else None
                if mine and (group.part is not None or (verb is not None and verb.kind in STRIKES | {"collide"})):
                    return True
        return False

    def _be_two(self) -> None:
        """Make places for vehicles that a text names only together: "two pickups met"."""
        alike = next((each.bodies for row in self.found for each in row if each.bodies), ())
        if alike and not self.vehicles:
            self.vehicles = [MentionedVehicle(place, Description(bodies=alike)) for place in range(2)]

    def _lead_in(self) -> None:
        """Let somebody without a vehicle who strikes one of two be the other's driver."""
        if len(self.vehicles) != 2:
            return
        for structure, row in zip(self.structures, self.found, strict=True):
            for group in structure.groups:
                person = group.mention
                if person is None or person.kind is not MentionKind.PERSON or person.vehicles or not person.is_new:
                    continue
                at = structure.owner(group.top)
                verb = structure.items[at].verb if at is not None else None
                struck = [each for each in row if each.vehicles and each.first > group.last]
                if verb is not None and verb.kind in STRIKES and struck and structure.subject(at or 0) is group:
                    self._note(
                        structure.sentence.index, person, self.vehicles[1 - struck[0].vehicles[0]], is_title=False
                    )

    def _describe_alike(self) -> None:
        """Give vehicles of which nothing is known what "two pickups" says of all."""
        alike = next((each.bodies for row in self.found for each in row if each.bodies), ())
        for vehicle in self.vehicles if alike else ():
            if vehicle.description.body()[0] is None:
                vehicle.description = replace(vehicle.description, bodies=alike)

    def _put_in_order(self) -> None:
        """Put the vehicles into the order in which they, or who drives them, come up."""
        if any(each.description.number is not None for each in self.vehicles):
            return
        self._begin_with_writer()
        late = max((each.first or 0 for each in self.vehicles), default=0) + 1
        old = sorted(self.vehicles, key=lambda each: (late if each.first is None else each.first, each.place))
        new = {each.place: at for at, each in enumerate(old)}
        for mention in (each for row in self.found for each in row):
            mention.vehicles = tuple(new[place] for place in mention.vehicles)
        for at, vehicle in enumerate(old):
            vehicle.place = at
        self.vehicles = old

    def _begin_with_writer(self) -> None:
        """Who leaves himself out comes up where his first verb stands: "Left the yard at nine"."""
        own = self.own
        for structure in self.structures if own is not None else ():
            start = next(
                (
                    item.span.start
                    for at, item in enumerate(structure.items.cut(0, _OPENING))
                    if _is_told(structure, at)
                ),
                None,
            )
            if own is not None and start is not None:
                own.first = start if own.first is None else min(own.first, start)


def _is_told(structure: Structure, at: int) -> bool:
    """Whether a verb opens a sentence that has no subject."""
    verb = structure.items[at].verb
    drives = verb is not None and verb.form in {"past", "both", "ing"} and verb.kind in _DRIVES | STRIKES | {"depart"}
    bare = structure.tree[at].relation == "ROOT" and not structure.tree.has(at, *SUBJECTS)
    return drives and bare and structure.is_predicate(at) and not any(each.first < at for each in structure.groups)


def _is_somebody(structure: Structure, mention: Mention) -> bool:
    """Whether a mention is of a person who may drive, not of "anybody"."""
    return any(
        item.get("person") in {"driver", "someone"} for item in structure.items.cut(mention.first, mention.last + 1)
    )


def _called(structure: Structure, mention: Mention) -> str:
    """What a person is called; empty for "driver", who may be anybody's."""
    for item in reversed(structure.items.cut(mention.first, mention.last + 1)):
        if item.get("person") in {"someone", "other"} or (item.is_name and not item.kinds):
            return item.low
    return ""
