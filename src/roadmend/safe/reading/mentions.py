"""Where a text speaks of vehicles, and which vehicle each time."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from roadmend.safe.reading.cast import VehicleRoll
from roadmend.safe.reading.naming import Mention, MentionKind, mentions_of
from roadmend.safe.reading.persons import seat_by_name, seat_by_role
from roadmend.safe.reading.seats import (
    add_writer,
    claim_own,
    couple,
    lead_in,
    let_speak,
    possess,
    put_in_order,
    seat_people,
    seat_persons,
    seat_writer,
)
from roadmend.safe.reading.tokens import Sentence

_HEADLINE = 16  # words


@dataclass(slots=True)
class Spoken:
    """The vehicles of a text and where it speaks of them, by sentence."""

    roll: VehicleRoll = field(default_factory=VehicleRoll)
    mentions: list[list[Mention]] = field(default_factory=list)


def find_mentions(sentences: Sequence[Sentence]) -> Spoken:
    """Find all mentions of a text, and name the vehicles that are called by number or description."""
    spoken, found = Spoken(), [list(mentions_of(sentence.items)) for sentence in sentences]
    roll = spoken.roll
    roll.enrol(sorted({each.number for row in found for each in row if each.number}))
    speakers = let_speak(sentences, found)
    for sentence, row in zip(sentences, found, strict=True):
        couple(sentence.items, row)
        claim_own(sentence.items, row)
        for mention in row:  # first, for a report may speak of "a 2004 Civic" before it gives it a number
            if mention.description is not None and mention.number is not None:
                mention.vehicles = roll.call(mention.description, is_new=False, is_headline=False)
    paragraphs = {id(each): at.paragraph for at, row in zip(sentences, found, strict=True) for each in row}
    firsts: dict[int, int] = {}
    for each in (each for row in found for each in row if each.number):
        firsts.setdefault(each.vehicles[0], each.span.start)
    headlines = [_is_headline(sentence, sentences) for sentence in sentences]
    in_body = any(
        each.description for row, is_title in zip(found, headlines, strict=True) if not is_title for each in row
    )
    for is_headline, row in sorted(zip(headlines, found, strict=True), key=lambda each: each[0]):
        for mention in row:
            if mention.twin is not None and mention.twin.vehicles:
                mention.vehicles = mention.twin.vehicles
            if mention.vehicles:
                roll.latest = mention.vehicles[0]
            elif mention.description is not None:
                early = roll.to_come(mention.description, mention.span.start, firsts)
                if early:
                    mention.vehicles = early
                elif is_headline and in_body:  # a headline tells of those of whom the text tells
                    mention.vehicles = roll.known(mention.description)
                else:
                    is_new = mention.is_new and not roll.is_told_again(mention.description, paragraphs[id(mention)])
                    mention.vehicles = roll.call(mention.description, is_new=is_new, is_headline=is_headline)
                    roll.note(mention.vehicles, paragraphs[id(mention)])
    possess(sentences, found)
    seat_people(sentences, found)
    seat_by_role(sentences, found)
    seat_by_name(sentences, found)
    seat_writer(sentences, found, roll)
    add_writer(sentences, found, roll)
    alike = next((each.bodies for row in found for each in row if each.bodies), ())
    for vehicle in roll.vehicles if alike else ():
        if vehicle.description.body()[0] is None:
            vehicle.description = replace(vehicle.description, bodies=alike)
    lead_in(sentences, found, headlines, roll)
    put_in_order(sentences, found, headlines, roll)
    own = roll.own()
    for sentence, row in zip(sentences, found, strict=True):
        seat_persons(sentence.items, row)
        for mention in row:
            if mention.kind is MentionKind.SELF:
                told = speakers.get(id(mention))
                mention.vehicles = own if told is None else told.vehicles
        spoken.mentions.append(list(row))
    return spoken


def _is_headline(sentence: Sentence, sentences: Sequence[Sentence]) -> bool:
    """Whether it stands alone over a text, as a newspaper's headline does."""
    alone = sum(each.paragraph == sentence.paragraph for each in sentences) == 1
    return alone and sentence.paragraph == 0 and len(sentence.items) < _HEADLINE and len(sentences) > 1
