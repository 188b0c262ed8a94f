"""What a clause is: who does what, to whom, where, and how certain it is."""

from dataclasses import dataclass, field

from roadmend.safe.claims import Span
from roadmend.safe.reading.lexicon import VerbSense
from roadmend.safe.reading.parts import NamedPart
from roadmend.safe.reading.tokens import Item, Sentence, Words

STRIKES = frozenset({"strike", "strike_rear", "strike_side", "strike_swipe"})


@dataclass(frozen=True, slots=True)
class Actor:
    """One or more vehicles in a clause.

    Attributes:
        vehicles: by place in the cast; empty where it is open which.
        part: that is spoken of.
        is_person: whether it is the driver who is spoken of.
        span: in the summary.
        gender: "f" or "m", where the text says so.
    """

    vehicles: tuple[int, ...]
    part: NamedPart | None
    is_person: bool
    span: Span
    gender: str = ""


NOBODY = Actor((), None, is_person=False, span=Span(0, 0))


@dataclass(slots=True)
class Clause:
    """One statement.

    Attributes:
        sentence: that it stands in.
        subject: who does it; :data:`NOBODY` where that is open.
        verb: what; None where there is none.
        is_passive: whether it is done to the subject.
        is_denied: whether it is said not to be.
        governed: kinds of the verbs that it depends on: "began", "tried", "failed".
        object: to whom.
        others: what prepositions bring in, each with its preposition.
        head: words between subject and verb.
        tail: words after the verb.
        span: in the summary.
    """

    sentence: Sentence
    subject: Actor
    verb: VerbSense | None
    is_passive: bool = False
    is_denied: bool = False
    governed: frozenset[str] = frozenset()
    object: Actor | None = None
    others: list[tuple[Item, Actor]] = field(default_factory=list)
    head: Words = field(default_factory=Words)
    tail: Words = field(default_factory=Words)
    span: Span = field(default=Span(0, 0))

    @property
    def kind(self) -> str:
        """Of the verb; empty where there is none."""
        return self.verb.kind if self.verb is not None else ""

    @property
    def lemma(self) -> str:
        """Of the verb; empty where there is none."""
        return self.verb.lemma if self.verb is not None else ""

    @property
    def words(self) -> Words:
        """All its words but those that name vehicles."""
        return Words(self.head + self.tail)

    @property
    def is_real(self) -> bool:
        """Whether it is said to have happened, not only to have been meant or missed."""
        return not self.is_denied and not self.governed & {"intend", "avoid"}
