"""One sentence with its noun groups and its tree: which words say what happens, and what each of them governs."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from roadmend.safe.reading.groups import NounGroup
from roadmend.safe.reading.syntax import Tree
from roadmend.safe.reading.tokens import Item, Sentence, Words

SUBJECTS = ("nsubj", "nsubjpass", "csubj")
_NO_PREDICATE = frozenset({"amod", "compound", "aux", "auxpass", "det", "prep", "case", "poss", "nmod", "prt", "fixed"})
_BENT = frozenset({"ROOT", "conj", "relcl", "acl", "advcl", "ccomp", "xcomp"})
_LEADS = ("preposition", "ahead", "behind", "beside", "oncoming", "path", "ends")
_CLIMB = 3  # verbs above one that has no subject of its own


@dataclass(frozen=True, slots=True)
class Structure:
    """A sentence taken apart.

    Attributes:
        sentence: itself.
        groups: of nouns that name vehicles, in their order.
        tree: how its words hang together.
    """

    sentence: Sentence
    groups: Sequence[NounGroup]
    tree: Tree

    @property
    def items(self) -> Words:
        """Its words."""
        return self.sentence.items

    def is_predicate(self, at: int) -> bool:
        """Whether a word says what happens or is."""
        item, arc = self.items[at], self.tree[at]
        if self.group(at) is not None or arc.relation in _NO_PREDICATE:
            return False
        if item.low == "left" and arc.lemma != "leave":
            return False
        if arc.tag in {"VERB", "AUX"}:
            return arc.tag == "AUX" or item.verb is not None or not item.is_a("bound", "hand")
        is_bent = item.verb is not None and item.verb.form != "base" and arc.tag in {"NOUN", "ADJ", "PROPN", "X"}
        return is_bent and arc.relation in _BENT

    def group(self, at: int) -> NounGroup | None:
        """The noun group that a word is of."""
        return next((each for each in self.groups if each.first <= at <= each.last), None)

    def owner(self, at: int) -> int | None:
        """The predicate that a word belongs to; None where there is none."""
        return next((up for up in (at, *self.tree.chain(at)) if self.is_predicate(up)), None)

    def lead(self, group: NounGroup) -> Item | None:
        """The preposition that brings a noun group in."""
        before, at = self.items.at(group.first - 1), self.tree[group.top].head
        for item in (before, self.items[at] if at < group.first else before):
            if item.is_a(*_LEADS) and item.low != "before":
                return item
        return before if before.low in {"than", "as"} else None

    def joined(self, group: NounGroup) -> Iterator[NounGroup]:
        """A noun group and those that "and" joins to it."""
        yield group
        for other in self.tree.children(group.top, "conj"):
            more = self.group(other)
            if more is not None and more is not group:
                yield more

    def within(self, place: int) -> NounGroup | None:
        """The vehicle that a person, a part or a load is of, or in: "some kid in a Civic", "a trailer that"."""
        head = self.tree[place].head
        if self.items[head].low == "with" and (carrier := self.group(max(0, head - 1))) is not None:
            return carrier  # "a lorry with a trailer that"
        named = (
            self.items[place].is_name
            and not self.items[place].kinds
            and not self.items.at(place + 1).is_a("road", "lane")
        )
        if self.items[place].is_a("person", "part", "body", "axlewords") or named:
            inner = [
                each
                for each in self.groups
                if place in {*self.tree.chain(each.top)} and self.owner(each.top) == self.owner(place)
            ]
            return inner[0] if inner else None
        return None

    def doer(self, at: int) -> int | None:
        """The word for who does what the predicate over a word says, in or out of a noun group."""
        owner = self.owner(at)
        for _ in range(_CLIMB):
            if owner is None:
                return None
            named = [each for each in self.tree.children(owner, *SUBJECTS) if not self.items[each].is_a("relative")]
            if named:
                return named[0]
            if self.tree[owner].relation in {"relcl", "acl"}:
                return self.tree[owner].head
            owner = next((each for each in self.tree.chain(owner) if self.is_predicate(each)), None)
        return None

    def subject(self, at: int) -> NounGroup | None:
        """The noun group that does what a predicate says, where the sentence names it."""
        for _ in range(_CLIMB):
            arc = self.tree[at]
            named = [child for child in self.tree.children(at, *SUBJECTS) if not self.items[child].is_a("relative")]
            if named:
                return self.group(named[0]) or self.within(named[0])
            if arc.relation in {"relcl", "acl"}:
                return self.group(arc.head) or self.within(arc.head)
            up = next((each for each in self.tree.chain(at) if self.is_predicate(each)), None)
            if up is None:
                return None
            at = up
        return None
