"""Incidents in words: those of traffic, which the scenario bank's lexicon knows."""

from roadmend.sera.incident import EgoAction, Encounter, Incident, IncidentKind, PlaceKind, Verdict

KINDS: dict[IncidentKind, str] = {
    "collision": "collision",
    "timeout": "time-out",
    "off_route": "off the route",
    "intervention": "intervention",
}
PLACES: dict[PlaceKind, str] = {
    "before_junction": "before the intersection",
    "in_junction": "in the intersection",
    "after_junction": "behind the intersection",
    "at_crossing": "at a pedestrian crossing",
    "ramp": "on the on-ramp",
    "acceleration_lane": "in the acceleration lane",
    "highway": "on the highway",
    "exit_lane": "in the exit lane",
    "lane": "on the open road",
}
_AT = {"on_ramp": " at an on-ramp", "highway_exit": " before an exit"}  # of a highway
ACTIONS: dict[EgoAction, str] = {
    "turning_left": "turns left",
    "turning_right": "turns right",
    "crossing_straight": "goes straight on",
    "changing_lane": "changes lane",
    "standing": "stands",
    "driving_on": "drives on",
}
ENCOUNTERS: dict[Encounter, str] = {
    "crossing_from_left": "crosses from the left",
    "crossing_from_right": "crosses from the right",
    "oncoming_turn": "turns across from the opposite direction",
    "oncoming": "comes from the opposite direction",
    "cut_in": "cuts in",
    "braking_leader": "brakes hard ahead",
    "standing_leader": "stands ahead",
    "slow_leader": "drives slowly ahead",
    "follower": "comes from behind",
    "in_target_lane": "drives in the lane that the ego changes to",
    "alongside": "drives alongside",
    "pedestrian": "crosses on foot",
}
VERDICTS: dict[Verdict, str] = {
    "no_method": "no repair method at work",
    "not_at_all": "the repair node did nothing",
    "too_late": "the repair node stepped in too late",
    "too_weak": "the repair node stepped in in time and too weakly",
    "struck_while_braking": "the ego was struck while the repair node held it back",
    "held_the_ego": "the repair node held the ego",
    "not_involved": "the repair node was not involved",
    "needed": "the plan would have ended in contact",
    "close": "the plan would have come near",
    "no_need_seen": "no need to be seen in the recording",
    "controlled_stop": "inputs were missing or invalid",
}


def words_of_incident(incident: Incident) -> str:
    """What happened, where, and who was in it; no figures, so that like incidents read alike."""
    place, ego, other = PLACES[incident.place.kind], ACTIONS[incident.ego.action], incident.other
    place += _AT.get(incident.where.road or "", "") if incident.place.kind == "highway" else ""
    text = f"{KINDS[incident.kind]} {place}: the ego {ego}"
    if other is not None:
        text += f", a {other.kind or 'participant'} {ENCOUNTERS[other.encounter]}"
    return text


def note_of_incident(incident: Incident) -> str:
    """What is special about one incident: how long before contact braking would have helped, and the repair."""
    parts = []
    if incident.kind == "collision":
        parts.append(
            "not avoidable by braking"
            if incident.avoidable is None
            else f"avoidable until {incident.avoidable:.2f} s before contact"
        )
    repair = VERDICTS[incident.repair.verdict]
    if incident.repair.frames:
        frames = incident.repair.frames
        repair += f" ({frames} frame{'' if frames == 1 else 's'}, dose {incident.repair.dose:.2f} s)"
    return "; ".join([*parts, repair])
