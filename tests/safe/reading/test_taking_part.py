"""Who takes part in a crash: which vehicles a text tells of, what they are, and who only looks on."""

import pytest

from roadmend.safe.reading.reader import read_claims

SEDAN, SUV, VAN, PICKUP, TRUCK = "Sedan", "SUV", "Minivan", "Pickup", "Semi Truck"


def taking_part(text):
    said = read_claims(text)
    vehicles = said.text.spoken.roll.vehicles
    return [vehicles[place].description.body()[0] for place in said.kept]


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("P1 (TOYT Camry) NB Oak. P2 (CHEV Silverado) WB 5th. P2 front vs P1 right side.", [SEDAN, PICKUP]),
        ("Vehicle A is a Honda Fit. Vehicle B is a Ford Escape. A was turning left. B hit A.", [SEDAN, SUV]),
        ("#1 Kia Sorento EB on 6. #2 Dodge Ram WB, turned left into #1.", [SUV, PICKUP]),
        ("Two lanes, dry. I (Tacoma) stopped. A Jetta didn't, and hit me.", [PICKUP, SEDAN]),
        ("Me: Equinox, stopped. Him: Ram, not stopped. His front, my rear.", [SUV, PICKUP]),
        ("Tundra, mine. I was going west on Oak. An Accord pulled out and hit my door.", [PICKUP, SEDAN]),
        ("Insd in Equinox e/b. OV (also an SUV) ran the stop sign & hit insd door.", [SUV, SUV]),
        ("Your insured's Sentra ran the light. Our member's Odyssey was hit broadside.", [SEDAN, VAN]),
        ("At the light Explorer hit the Silverado from behind.", [SUV, PICKUP]),
        ("I drive behind a Golf. He stop and I hit him with my Duster.", [SUV, SEDAN]),
        ("She was in the Rogue. It was a semi that came round the bend. Hit the Rogue head on.", [SUV, TRUCK]),
        ("A Mack hauling a dry van trailer changed lanes and struck a Corolla.", [TRUCK, SEDAN]),
        ("Two pickups met head-on. One was heading north, the other south.", [PICKUP, PICKUP]),
    ],
)
def test_who_is_who(text, wanted):
    assert taking_part(text) == wanted


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("Three-car pileup: a Jetta stopped, a RAV4 behind it stopped, and a Silverado did not.", [SEDAN, SUV, PICKUP]),
        ("A Lexus RX350 slid off the road. No other vehicles involved. A passing Tundra called it in.", [SUV]),
        ("A Civic hit a pole. It was missed by a southbound dump truck.", [SEDAN]),
        ("A Civic hit a RAV4. The Kia behind them is a spectator, not a party.", [SEDAN, SUV]),
        ("A Camry hit a pole. It was not a pickup, as the caller thought.", [SEDAN]),
    ],
)
def test_who_only_looks_on(text, wanted):
    assert taking_part(text) == wanted


def test_a_numbered_vehicle_took_part_though_another_missed_it():
    text = "Vehicle 1, a Jeep Cherokee, slowed. Vehicle 2, an Acura TL, swerved to avoid it and hit a tree."
    assert taking_part(text) == [SUV, SEDAN]


def test_a_later_paragraph_tells_of_the_same_vehicles():
    lead = "A couple remained in hospital after a pickup ran a red light and hit their sedan, police said.\n\n"
    assert taking_part(f"{lead}As their sedan crossed Third Street, a southbound pickup rammed it.") == [PICKUP, SEDAN]
