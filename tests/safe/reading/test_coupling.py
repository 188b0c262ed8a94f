"""Two names side by side are one vehicle's, and two vehicles side by side stay two."""

import pytest

from roadmend.safe.dsl_data import dump_data
from roadmend.safe.reading.coupling import let_speak
from roadmend.safe.reading.naming import MentionKind, mentions_of
from roadmend.safe.reading.reader import read_summary
from roadmend.safe.reading.tokens import read_sentences

from .apart import named


@pytest.mark.parametrize(
    "text",
    [
        "Vehicle 1, a 2004 Honda Civic, was northbound.",
        "V2 (a Ford pickup) was stopped.",
        "The car in front of me, a Toyota Highlander, stopped.",
    ],
)
def test_a_name_and_its_description_are_of_one_vehicle(text):
    _, row = named(text)
    first, second = (each for each in row if each.description is not None)
    assert second.twin is first
    assert first.description == second.description
    assert first.description.names


@pytest.mark.parametrize("text", ["V1 struck a Honda Civic.", "V1 and V2 were northbound."])
def test_two_vehicles_stay_two(text):
    _, row = named(text)
    assert len(row) == 2
    assert all(each.twin is None for each in row)


def test_each_driver_speaks_of_himself():
    sentences = read_sentences("Driver 1: I was going straight. I braked. Driver 2: I turned left.")
    found = [list(mentions_of(sentence.items)) for sentence in sentences]
    let_speak(sentences, found)
    selves = [each for row in found for each in row if each.kind is MentionKind.SELF]
    assert [each.speaker.number for each in selves] == [1, 1, 2]


def test_what_a_driver_says_of_himself_is_of_his_vehicle():
    said = read_summary(
        "Driver 1: I was going north on Main Street in my Honda Civic. Driver 2: I was driving a Ford F-150 west on Oak Street "
        "and I struck the Civic in the right side."
    )
    data = dump_data(said.scenario)
    assert [(each["model"], each["initial_position"]) for each in data["vehicles"]] == [
        ("Sedan", "S2N"),
        ("Pickup", "E2W"),
    ]
