"""A sentence taken apart as the reader does it, for tests of what it is made of."""

from roadmend.safe.reading.coupling import couple
from roadmend.safe.reading.groups import groups_of
from roadmend.safe.reading.naming import mentions_of
from roadmend.safe.reading.structure import Structure
from roadmend.safe.reading.syntax import parse
from roadmend.safe.reading.tokens import read_sentences


def named(text):
    """The only sentence of a text, and its mentions of vehicles."""
    (sentence,) = read_sentences(text)
    row = list(mentions_of(sentence.items))
    couple(sentence.items, row)
    return sentence, row


def taken_apart(text):
    """The structure of the only sentence of a text."""
    sentence, row = named(text)
    groups = groups_of(sentence.items, row)
    return Structure(sentence, groups, parse([sentence], [groups])[0])


def words(items, group):
    """What a noun group says, word by word; None where there is no group."""
    return None if group is None else " ".join(item.low for item in items[group.first : group.last + 1])
