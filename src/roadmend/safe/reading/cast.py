"""The vehicles of a text: each described in one or more ways, and told apart by them."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from roadmend.safe.claims import Span
from roadmend.safe.dsl import DslModel
from roadmend.safe.reading.lexicon import BodySense, NameSense

_NAME_CONFIDENCE = 0.96
_LIGHT = {DslModel.SEDAN, DslModel.SUV, DslModel.MINIVAN, DslModel.PICKUP}
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
        models = {name.model for name in self.names if name.model}
        theirs = {name.model for name in other.names if name.model}
        if models and theirs:
            return not _alike(models, theirs)
        if makes and others and not makes & others:
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
    """A vehicle of the text, with who drives it.

    Attributes:
        place: in the cast, from 0.
        description: all that was said of it.
        first: where it, or who drives it, was first spoken of.
        is_headline: whether only the headline has spoken of it so far.
        words: all its names.
        people: what its driver is called: "nurse", a surname.
        ways: directions that its names tell, "N" of "a northbound sedan".
        latest: the sentence that spoke of it last.
    """

    place: int
    description: Description
    first: int | None = None
    is_headline: bool = False
    words: list[str] = field(default_factory=list)
    people: set[str] = field(default_factory=set)
    ways: set[str] = field(default_factory=set)
    latest: int = 0

    @property
    def is_known(self) -> bool:
        """Whether the text has said what kind of vehicle it is."""
        return bool(self.description.names or self.description.bodies)


@dataclass(slots=True)
class VehicleRoll:
    """The vehicles of a text in the order in which they come up; numbered ones by number."""

    vehicles: list[MentionedVehicle] = field(default_factory=list)

    def own(self) -> tuple[int, ...]:
        """The writer's own vehicle, if one is known."""
        return next(((each.place,) for each in self.vehicles if each.description.is_own), ())


def shares_name(one: Description, other: Description) -> bool:
    """Whether both are called by one make or model."""
    makes, models = {name.make for name in one.names}, {name.model for name in one.names if name.model}
    theirs = {name.model for name in other.names if name.model}
    if models and theirs:
        return _alike(models, theirs)
    return bool(makes & {name.make for name in other.names})
