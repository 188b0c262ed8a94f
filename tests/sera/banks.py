"""Small banks to test with."""

import dataclasses

from roadmend.sera.descriptor import BankEntry, Descriptor, Hazard, OutcomeStatistics, RoadDescriptor

PLAIN = Descriptor(
    road=RoadDescriptor("highway_exit", 2, 27.78),
    manoeuvre="exit",
    participants={"car": 3},
    drivers={"normal": 3},
    hazards=(),
    weather="clear",
    light="daytime",
    friction=0.9,
    sensing_range=150.0,
    ego_speed=20.0,
    family="S4",
)


def entry(name, **changes):
    return BankEntry(f"digest-{name}", name, "test", dataclasses.replace(PLAIN, **changes))


def cut_in(participant="car", side="left"):
    return (Hazard("cut_in", participant, side, 12.0),)


def ran(outcome, distance=0.0, policy="modular"):
    return (OutcomeStatistics(policy, {outcome: 1}, distance),)
