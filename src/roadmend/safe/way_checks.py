"""What a judge asks of every vehicle of a run: where it comes from and goes to, on which road, and whether it can so move."""

import math

from roadmend.core.tick import INTERVAL
from roadmend.safe.contact import Contact
from roadmend.safe.crash_record import CrashRecord
from roadmend.safe.likeness import Run, any_near, in_degrees, vehicle_name
from roadmend.safe.run_map import heading_at_end, roads_at, stem_at

_APPROACH = 2.0  # [s] before a contact, when nobody had begun to turn away from it


def check_origin(run: Run, record: CrashRecord, number: int, first: Contact, last: int) -> str:
    """How the heading with which a vehicle comes differs from the record's; empty if it does not.

    Args:
        run: to judge.
        record: to judge it by.
        number: of the vehicle.
        first: contact of the run.
        last: tick up to which the vehicle is looked at.
    """
    vehicle = record.vehicle(number)
    track = run.film.track(vehicle_name(number))
    track = track[track[:, 0] <= last]
    if vehicle.origin is None or not len(track):
        return ""
    backwards = math.pi if vehicle.reverses else 0.0
    headings = [track[0, 3] + backwards]
    if "Curve" in roads_at(run.scenario.network, first.x, first.y):
        # In a bend a report may name the direction before it or the one at the place.
        headings.append(track[max(0, len(track) - 1 - round(_APPROACH / INTERVAL)), 3] + backwards)
    if any_near(vehicle.origin, headings):
        return ""
    return f"{vehicle_name(number)} came heading {in_degrees(headings[0]):.0f} deg, not {vehicle.origin:.0f}"


def check_destination(run: Run, record: CrashRecord, number: int, last: int | None = None) -> str:
    """How the heading that a vehicle was going to have differs from the record's; empty if it does not.

    Args:
        run: to judge.
        record: to judge it by.
        number: of the vehicle.
        last: tick at which its way ended before its route did, where it left that; its heading then counts too.
    """
    vehicle, name = record.vehicle(number), vehicle_name(number)
    if vehicle.destination is None or not len(run.film.track(name)):
        return ""
    backwards = math.pi if vehicle.reverses else 0.0
    headings = heading_at_end(run.scenario, None if name == run.film.ego_name else name, of_route=last is not None)
    if last is not None:
        track = run.film.track(name)
        headings = [*headings, *track[track[:, 0] <= last][-1:, 3]]
    if any_near(vehicle.destination, [heading + backwards for heading in headings]):
        return ""
    return f"{name} was going to head {in_degrees(headings[-1]):.0f} deg, not {vehicle.destination:.0f}"


def check_road(run: Run, record: CrashRecord, first: Contact) -> str:
    """How the type of road at the first contact, or its stem, differs from the record's; empty if neither does."""
    found = roads_at(run.scenario.network, first.x, first.y)
    if record.roads and not found & {*record.roads}:
        return f"the place is of type {' or '.join(sorted(found))}, not {' or '.join(record.roads)}"
    stem = stem_at(run.scenario.network)
    if record.stem is not None and stem is not None and not any_near(record.stem, [stem]):
        return f"the stem lies at {in_degrees(stem):.0f} deg, not {record.stem:.0f}"
    return ""


def check_physical(run: Run, _record: CrashRecord, _first: Contact) -> str:
    """Who moves as no vehicle can; empty if nobody does."""
    for name, motion in run.motions.items():
        if not motion.is_physical:
            return f"{name} had {motion.longitudinal:.1f} m/s2 along and {motion.lateral:.1f} m/s2 across its way"
    return ""
