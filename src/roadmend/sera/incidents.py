"""Finds the incidents of a recorded episode: its failure, if it ended in one, and every intervention."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from roadmend.core.errors import InputError
from roadmend.core.outcome import Event, EventKind
from roadmend.core.route import Route
from roadmend.core.scene import ObjectList, Scene
from roadmend.measures.route_progress import RoutePlace, RouteProgress
from roadmend.recording.episode import BagEpisode, episode_of
from roadmend.recording.reader import BagReader
from roadmend.recording.recorded_run import recorded_scenario
from roadmend.sera.avoidability import LOOK_BACK, last_avoidable
from roadmend.sera.describe import describe
from roadmend.sera.descriptor import Descriptor
from roadmend.sera.encounter import KINDS, braking_of, classify, hazard_of
from roadmend.sera.incident import Incident, IncidentEgo, IncidentKind, IncidentPlace, Other, RepairAccount
from roadmend.sera.pattern import Where
from roadmend.sera.place import action_of, is_changing, junction_zone, place_of
from roadmend.sera.repair_account import (
    Intervention,
    account_of_failure,
    account_of_intervention,
    account_of_standstill,
    interventions_of,
    plan_gap,
)
from roadmend.sera.track import Track, track_of
from roadmend.training.collision import describe_collision
from roadmend.world.blame import find_blame
from roadmend.world.scenario import Environment, Scenario

ENCOUNTER = 4.0  # [s] before an incident in which the other's manoeuvre is read
_UNFOLDS = 2.0  # [s] after the beginning of an intervention that are read, too
_BLOCKING = 15.0  # [m] within which somebody ahead may be why the ego stands
_PLAN_MEETS = 1.0  # [m] gap on the policy's plan up to which an intervention is about that participant
_FAILURES: dict[EventKind, IncidentKind] = {
    EventKind.COLLISION: "collision",
    EventKind.TIMEOUT: "timeout",
    EventKind.OFF_ROUTE: "off_route",
}


def find_incidents(path: Path) -> tuple[Incident, ...]:
    """The incidents of the episode in a bag, in the order of their time.

    Raises:
        InputError: there is no such bag, it is corrupt, or it does not hold an episode with its route.
    """
    reader = BagReader(path)
    episode = episode_of(reader)
    if episode.route is None:
        raise InputError(str(path), "holds no route of the ego", "name a bag that an episode was recorded into")
    finder = _Finder(episode, episode.route, recorded_scenario(reader))
    return tuple(sorted(finder.all(), key=lambda incident: (incident.time, incident.kind)))


@dataclass(frozen=True, slots=True)
class _Moment:
    """The ego at one tick."""

    stamp: int  # [ns]
    place: RoutePlace
    words: IncidentPlace
    changing: bool


class _Finder:
    def __init__(self, episode: BagEpisode, route: Route, scenario: Scenario | None) -> None:
        self._episode = episode
        self._route = route
        self._scenario = scenario
        self._descriptor: Descriptor | None = None if scenario is None else describe(scenario)
        self._environment = Environment() if scenario is None else scenario.environment
        progress = RouteProgress(route)
        self._places = {stamp: progress.observe(episode.ego[stamp]) for stamp in episode.stamps}
        self._names = {
            identity: name
            for event in episode.events
            for identity, name in zip(event.object_ids, event.object_names, strict=False)
        }

    def all(self) -> Iterator[Incident]:
        for event in self._episode.events:
            if event.kind in _FAILURES:
                yield self._failure(event, _FAILURES[event.kind])
        for intervention in interventions_of(self._episode):
            gap = plan_gap(self._episode, intervention.begin)
            account = account_of_intervention(self._episode, intervention, None if gap is None else gap[0])
            identity = self._whom(intervention.begin, gap)
            other = None if identity is None else self._other(self._unfolded(intervention), identity)
            yield self._incident("intervention", self._moment(intervention.begin), other, account)

    def _failure(self, event: Event, kind: IncidentKind) -> Incident:
        moment = self._moment(round(event.time * 1e9))
        if kind != "collision":
            account = account_of_standstill(self._episode, moment.stamp)
            blocking = self._in_the_way(moment.stamp)
            other = None if blocking is None else self._other(moment, blocking)
            return self._incident(kind, moment, other, account, event)
        identity = event.object_ids[0] if event.object_ids else None
        other = None if identity is None else self._other(moment, identity)
        avoidable = None if identity is None else self._avoidable(moment.stamp, identity)
        event = self._blamed(event, moment)
        account = account_of_failure(self._episode, moment.stamp, event.blame, avoidable)
        return self._incident(kind, moment, other, account, event, avoidable)

    def _incident(
        self,
        kind: IncidentKind,
        moment: _Moment,
        other: Other | None,
        account: RepairAccount,
        event: Event | None = None,
        avoidable: float | None = None,
    ) -> Incident:
        ego = self._episode.ego[moment.stamp]
        if other is not None and other.kind == "pedestrian":
            words = place_of(self._route, moment.place, self._descriptor, on_foot=True)
            moment = replace(moment, words=words)
        action = action_of(self._route, moment.place, ego, moment.words, changing=moment.changing)
        manoeuvre = None if self._descriptor is None else self._descriptor.manoeuvre
        is_collision = event is not None and event.kind == EventKind.COLLISION
        return Incident(
            kind=kind,
            bag=str(self._episode.path),
            time=round(moment.stamp * 1e-9, 3),
            where=self._where(),
            place=moment.words,
            ego=IncidentEgo(action, round(ego.speed, 2), manoeuvre),
            other=other,
            repair=account,
            manner=self._manner(moment.stamp, event) if event is not None and is_collision else "",
            at_fault=event.at_fault if event is not None and is_collision and event.blame else None,
            avoidable=avoidable,
            scenario="" if self._scenario is None else self._scenario.digest,
            policy=self._episode.account.get("policy", ""),
            text="" if event is None else event.text,
        )

    def _blamed(self, event: Event, moment: _Moment) -> Event:
        """A collision with its blame, which bags of earlier versions do not tell: found again in the scene."""
        objects = self._episode.objects.get(moment.stamp)
        if event.blame or objects is None or not event.object_ids:
            return event
        (places,) = np.nonzero(objects.id == event.object_ids[0])
        if not len(places):
            return event
        ego = self._episode.ego[moment.stamp]
        return replace(event, blame=find_blame(ego, objects, int(places[0]), changing=moment.changing))

    def _moment(self, stamp: int) -> _Moment:
        """The tick at a stamp, or the last before it."""
        stamp = max((known for known in self._places if known <= stamp), default=min(self._places))
        place = self._places[stamp]
        egos = [(known * 1e-9, self._episode.ego[known]) for known in self._episode.stamps if known <= stamp]
        events = [event for event in self._episode.events if event.time <= stamp * 1e-9]
        words = place_of(self._route, place, self._descriptor)
        return _Moment(stamp, place, words, is_changing(events, egos))

    def _unfolded(self, intervention: Intervention) -> _Moment:
        """The moment of an intervention at which it can be seen what the other did."""
        return self._moment(min(intervention.end, round(intervention.begin + _UNFOLDS * 1e9)))

    def _where(self) -> Where:
        known = self._descriptor
        if known is None:
            return Where()
        return Where(
            known.family,
            known.road.kind,
            known.road.control,
            known.road.lanes,
            known.road.speed_limit,
            known.density,
            known.weather,
            known.light,
        )

    def _other(self, moment: _Moment, identity: int) -> Other | None:
        track = self._track(identity, moment.stamp, ENCOUNTER)
        if track is None:
            return None
        first = int(track.stamp[0])
        ego = self._episode.ego.get(first) or self._episode.ego[moment.stamp]
        stage = self._route.stages[moment.place.stage]
        zone = junction_zone(self._route, moment.place)
        heading = ego.yaw if zone is None else stage.pose(zone.begin)[2]
        met = classify(track, ego, heading, stage, moment.place.position, changing=moment.changing)
        name = self._names.get(identity, "")
        actors = () if self._scenario is None else self._scenario.actors
        actor = next((actor for actor in actors if actor.id == name), None)
        return Other(
            identity,
            KINDS.get(track.kind),
            met.encounter,
            met.side,
            round(float(track.speed[-1]), 2),
            round(braking_of(track), 2),
            hazard_of(met, track, moment.words.right_of_way),
            name,
            None if actor is None else actor.driver,
        )

    def _track(self, identity: int, stamp: int, seconds: float) -> Track | None:
        return track_of(self._episode, identity, round(stamp - seconds * 1e9), stamp)

    def _avoidable(self, stamp: int, identity: int) -> float | None:
        track = self._track(identity, stamp, LOOK_BACK)
        if track is None:
            return None
        stamps = [known for known in self._episode.stamps if known <= stamp]
        egos = [self._episode.ego[known] for known in stamps]
        return last_avoidable(stamps, egos, track, self._environment.effective_friction)

    def _manner(self, stamp: int, event: Event) -> str:
        before = max((known for known in self._episode.objects if known < stamp), default=None)
        if before is None or before not in self._episode.ego:
            return ""
        ego, objects = self._episode.ego[before], self._episode.objects[before]
        scene = Scene(before * 1e-9, ego, objects, np.empty(0, dtype=np.uint8))
        collision = describe_collision(scene, event)
        return "" if collision is None else collision.manner

    def _whom(self, stamp: int, gap: tuple[float, int] | None) -> int | None:
        """Whom an intervention is about: whom the plan would have met, else who triggered it."""
        if gap is not None and gap[0] < _PLAN_MEETS:
            return gap[1]
        triggers = self._episode.repairs[stamp].triggers
        return triggers[0].object_id if triggers else None

    def _in_the_way(self, stamp: int) -> int | None:
        """Who is nearest before the ego's front, if anybody is."""
        ego, objects = self._episode.ego[stamp], self._episode.objects.get(stamp, ObjectList.empty())
        along = (objects.x - ego.x) * np.cos(ego.yaw) + (objects.y - ego.y) * np.sin(ego.yaw)
        across = (objects.y - ego.y) * np.cos(ego.yaw) - (objects.x - ego.x) * np.sin(ego.yaw)
        reach = 0.5 * (ego.width + objects.length)  # who stands across the way is as wide as it is long
        ahead = np.flatnonzero((along > 0.0) & (along < _BLOCKING) & (np.abs(across) < reach))
        return int(objects.id[ahead[np.argmin(along[ahead])]]) if len(ahead) else None
