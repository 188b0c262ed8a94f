"""The vehicles of a text: each described in one or more ways, and told apart by them."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from roadmend.safe.claims import Span
from roadmend.safe.dsl import DslModel
from roadmend.safe.reading.lexicon import BodySense, NameSense

_NAME_CONFIDENCE = 0.96
_LIGHT = {DslModel.SEDAN, DslModel.SUV, DslModel.MINIVAN, DslModel.PICKUP}
_PARKED = frozenset({"parked", "legally parked", "illegally parked", "unattended", "unoccupied", "double parked"})
_GENERIC = 0.8  # a word for a body that is surer than this rules others out
_LIKE: dict[str, set[DslModel | None]] = {
    "truck": {DslModel.PICKUP, DslModel.SEMI_TRUCK},
    "car": {DslModel.SEDAN, DslModel.SUV, DslModel.MINIVAN, None},
    "tractor": {DslModel.SEMI_TRUCK},
    "trailer": {DslModel.SEMI_TRUCK},
    "rig": {DslModel.SEMI_TRUCK},
    "bus": {DslModel.SEMI_TRUCK, DslModel.MINIVAN},
}


@dataclass(frozen=True, slots=True)
class Description:
    """What one mention says of a vehicle.

    Attributes:
        number: the report's.
        year: of the model.
        names: makes and models.
        bodies: words for its body, with their places.
        is_own: whether it is the writer's.
        is_other: whether it is "the other" one.
        is_theirs: whether it is "his" or "her" one.
        words: the name itself, in lower case.
        span: of the name.
        is_definite: whether it was spoken of before.
        marks: what else tells it from others: its colour, "first".
    """

    number: int | None = None
    year: int | None = None
    names: tuple[NameSense, ...] = ()
    bodies: tuple[tuple[BodySense, Span], ...] = ()
    is_own: bool = False
    is_other: bool = False
    words: str = ""
    span: Span | None = None
    is_definite: bool = True
    marks: frozenset[str] = frozenset()
    is_theirs: bool = False

    def merged(self, other: "Description") -> "Description":
        """Both together."""
        longer = max(self.words, other.words, key=len)
        return Description(
            self.number or other.number,
            self.year or other.year,
            (*self.names, *other.names),
            (*self.bodies, *other.bodies),
            self.is_own or other.is_own,
            self.is_other or other.is_other,
            longer,
            self.span if longer == self.words else other.span,
            self.is_definite and other.is_definite,
            self.marks | other.marks,
        )

    def body(self) -> tuple[DslModel | None, float, Span | None]:
        """The body class that fits best, how surely, and where it is said."""
        found: list[tuple[float, DslModel | None, Span | None]] = [
            (each.confidence, each.body, span) for each, span in self.bodies
        ]
        models = [name for name in self.names if name.model is not None] or list(self.names)
        found += [
            (_NAME_CONFIDENCE if name.model else _NAME_CONFIDENCE - 0.15, name.body, self.span)
            for name in models[:1]
            if name.body
        ]
        if not found:
            return None, 0.0, None
        confidence, body, span = max(found, key=lambda each: each[0])
        agree = {each for weight, each, _ in found if weight > _GENERIC}
        return body, confidence if len(agree) <= 1 else min(confidence, 0.85), span

    def contradicts(self, other: "Description") -> bool:
        """Whether the two cannot be of one vehicle."""
        makes, others = {name.make for name in self.names}, {name.make for name in other.names}
        if makes and others and not makes & others:
            return True
        models = {name.model for name in self.names if name.model}
        if models and (theirs := {name.model for name in other.names if name.model}) and not _alike(models, theirs):
            return True
        if bool(makes) and bool(others):
            return False
        for mine in (self, other):
            theirs_ = other if mine is self else self
            is_guess = not theirs_.bodies and all(name.model is None for name in theirs_.names)
            for sense, _ in mine.bodies:
                if is_guess and sense.body in _LIGHT and theirs_.body()[0] in _LIGHT:
                    continue  # "a van, a Nissan I think": a make builds several
                theirs_body, confidence, _ = theirs_.body()
                fits = _LIKE.get(mine.words.split(" ")[-1], {sense.body})
                if (
                    theirs_body is not None
                    and confidence > _GENERIC
                    and theirs_body not in fits
                    and (sense.confidence > _GENERIC or mine.words.split(" ")[-1] in _LIKE)
                ):
                    return True
        return False


def _alike(models: Iterable[str], others: Iterable[str]) -> bool:
    return any(one in other or other in one for one in models for other in others)


@dataclass(slots=True)
class MentionedVehicle:
    """A vehicle of the text.

    Attributes:
        place: in the cast, from 0.
        description: all that was said of it.
        first: where it was first spoken of.
        is_headline: whether only the headline has spoken of it so far.
        words: all its names.
        paragraphs: that speak of it.
    """

    place: int
    description: Description
    first: Span | None = None
    is_headline: bool = False
    words: list[str] = field(default_factory=list)
    paragraphs: set[int] = field(default_factory=set)


@dataclass(slots=True)
class VehicleRoll:
    """The vehicles so far, in the order in which they came up; numbered ones first, by number."""

    vehicles: list[MentionedVehicle] = field(default_factory=list)
    latest: int | None = None

    def enrol(self, numbers: Iterable[int]) -> None:
        """Make places for the vehicles that the text numbers."""
        for number in numbers:
            self.vehicles.append(MentionedVehicle(len(self.vehicles), Description(number=number)))

    def call(self, description: Description, *, is_new: bool, is_headline: bool) -> tuple[int, ...]:
        """The vehicle that is meant; a new one where none that is known can be."""
        vehicle = self._find(description, is_new=is_new)
        if vehicle is None and description.words == "trailer":
            return ()  # one that stands alone is no vehicle
        if vehicle is None:
            vehicle = MentionedVehicle(len(self.vehicles), description, description.span, is_headline)
            self.vehicles.append(vehicle)
        else:
            vehicle.description = vehicle.description.merged(replace(description, is_other=False))
            vehicle.first = vehicle.first or description.span
            vehicle.is_headline &= is_headline
        vehicle.words.append(description.words)
        self.latest = vehicle.place
        return (vehicle.place,)

    def known(self, description: Description) -> tuple[int, ...]:
        """The vehicle that is meant, if one is known."""
        body = description.body()[0]
        exact = [each for each in self.vehicles if body is not None and each.description.body()[0] is body]
        vehicle = exact[0] if len(exact) == 1 and not description.names else self._find(description, is_new=False)
        return () if vehicle is None else (vehicle.place,)

    def to_come(self, description: Description, start: int, firsts: Mapping[int, int]) -> tuple[int, ...]:
        """The vehicle that a report describes before it gives it its number."""
        body = description.body()[0]
        if body is None or description.number is not None:
            return ()
        fitting = [
            each
            for each in self.vehicles
            if firsts.get(each.place, -1) > start
            and each.description.body()[0] is body
            and not each.description.contradicts(description)
        ]
        return (fitting[0].place,) if fitting else ()

    def note(self, places: Iterable[int], paragraph: int) -> None:
        """Remember that a paragraph speaks of a vehicle."""
        for place in places:
            self.vehicles[place].paragraphs.add(paragraph)

    def is_told_again(self, description: Description, paragraph: int) -> bool:
        """Whether "a truck" is one of the lead of an article, of which a later paragraph tells at length."""
        body = description.body()[0]
        if body is None or description.number or description.is_other:
            return False
        mine = [each for each in self.vehicles if self._may_be(each, description) and not each.description.number]
        alike = [each for each in mine if each.description.body()[0] is body and not each.description.is_own]
        return (
            len(alike) == 1
            and bool(alike[0].paragraphs)
            and max(alike[0].paragraphs) < paragraph
            and (alike[0].paragraphs == {min(place for each in self.vehicles for place in each.paragraphs)})
        )

    def own(self) -> tuple[int, ...]:
        """The writer's own vehicle, if one is known."""
        return next(((each.place,) for each in self.vehicles if each.description.is_own), ())

    def _find(self, description: Description, *, is_new: bool) -> MentionedVehicle | None:
        if description.number is not None:
            return next(each for each in self.vehicles if each.description.number == description.number)
        if description.is_own:
            own = [each for each in self.vehicles if each.description.is_own]
            return own[0] if own else None
        fitting = [each for each in self.vehicles if self._may_be(each, description)]
        if description.words == "truck":  # nobody calls a bus so
            fitting = [each for each in fitting if not any(word.endswith("bus") for word in each.words)]
        if description.is_other and self.latest is not None:
            fitting = [
                each
                for each in fitting
                if each.place != self.latest and not (description.bodies and each.description.is_own)
            ]
        bare = [each for each in self.vehicles if not each.description.names and not each.description.bodies]
        is_told = bool(description.bodies or description.names)
        if is_new and len(self.vehicles) == len(bare) == 1 and is_told and not description.is_other:
            return bare[0]  # "a vehicle off the road: a sedan ran off"
        if not description.names and is_new:
            marked = [
                each for each in fitting if each.is_headline or each.description.marks & description.marks & _PARKED
            ]
            return marked[0] if marked else None  # "a car", "another truck": not one of those known
        same = [each for each in fitting if _shares_name(each.description, description)]
        if description.names and not same:
            unknown = [each for each in self.vehicles if not each.description.names and not each.description.bodies]
            if len(unknown) == 1 and len(self.vehicles) > 1 and all(each.description.number for each in self.vehicles):
                return unknown[0]  # of all that are numbered, only one was not described
            if is_new and any(name.model for name in description.names):
                bare = [
                    each
                    for each in fitting
                    if not each.description.names
                    and each.description.number is not None
                    and not each.description.bodies
                ]
                return bare[0] if len(bare) == 1 and len(self.vehicles) == 1 else None
            nameless = [each for each in fitting if not each.description.names and each.words]
            return nameless[-1] if len(nameless) == 1 else None
        pool = same or fitting
        if description.marks:
            pool = [each for each in pool if each.description.marks & description.marks] or pool
        with_words = [
            each
            for each in pool
            if description.words
            and any(description.words in words or words in description.words for words in each.words if words)
        ]
        pool = with_words or pool
        if description.words == "truck":  # who means a pickup says so where there is a heavier one
            pool = [each for each in fitting if each.description.body()[0] is DslModel.SEMI_TRUCK] or pool
        if description.words == "car":  # who has a sedan and a van before him calls the sedan a car
            pool = [each for each in pool if each.description.body()[0] is DslModel.SEDAN] or pool
        if len(pool) > 1 and description.is_definite and self.latest is not None and not description.marks:
            current = [each for each in pool if each.place == self.latest]
            pool = current or pool
        return pool[0] if pool else None

    def _may_be(self, vehicle: MentionedVehicle, description: Description) -> bool:
        if vehicle.description.number is not None and not vehicle.words and not description.names:
            return False  # nothing is known of it yet
        is_bus = any(word.endswith("bus") for word in vehicle.words)
        if is_bus and description.names and description.body()[0] not in {DslModel.SEMI_TRUCK, DslModel.MINIVAN, None}:
            return False
        colours = vehicle.description.marks and description.marks and not vehicle.description.marks & description.marks
        return not colours and not vehicle.description.contradicts(description)


def _shares_name(one: Description, other: Description) -> bool:
    makes, models = {name.make for name in one.names}, {name.model for name in one.names if name.model}
    theirs = {name.model for name in other.names if name.model}
    if models and theirs:
        return _alike(models, theirs)
    return bool(makes & {name.make for name in other.names})
