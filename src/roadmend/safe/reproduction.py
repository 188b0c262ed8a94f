"""Varies what a report leaves open until the described crash happens to the policy under test."""

import math
import random
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from roadmend.core.errors import RoadmendError
from roadmend.core.tick import INTERVAL
from roadmend.safe.construction import CrashRole, build_scenario, generator_of, plain_name
from roadmend.safe.described_crash import record_of, why_not_played
from roadmend.safe.judge import judge
from roadmend.safe.layout import lay_out
from roadmend.safe.likeness import Judgement, Likeness
from roadmend.safe.open_questions import answer, open_questions
from roadmend.safe.trial import CrashTestEpisode, run_trial
from roadmend.world.scenario import Scenario
from roadmend.world.space import Parameters, Space, Uniform, sample

REPRODUCED, NEAREST = "reproduced", "nearest"  # in the name of a scenario: whether it shows the described crash

_DIFFERENT = 0.8  # [m] of a gap that a difference in one dimension is worth
_RESTART = 12  # every so many episodes what was drawn anew is gone on from, whatever came before
_WEIGHTS = {Likeness.WHO: 3.0, Likeness.ORDER: 2.0, Likeness.PHYSICAL: 2.0}  # of a difference; others weigh 1
_NEAR = 1.5  # [m] between two places that count as the same when a meeting is looked for
_FRESH = 4  # every so many episodes one is drawn anew
_STEP = 0.15  # share of a dimension's range that a change moves it by, as a standard deviation
_OTHER_PART = 0.5  # [s] the same, from a contact on the wrong part: as long as a car takes to pass a place
_JITTER = 0.25  # [s] standard deviation around the delay that a film says would have led to a meeting


@dataclass(frozen=True, slots=True)
class CrashReproduction:
    """What the search for a report's crash came to with the policy in one role.

    Attributes:
        report: its name.
        vehicle: number of the vehicle whose place the ego took, from 1; None where it looked on.
        policy: name.
        episodes: driven until the crash happened, or in all; 0 where none could be.
        scenario: the one that is most like the described crash; None if nobody ever touched anybody.
        outcome: text of that episode's end, or why there is none.
        trial: that episode.
        own: how it lies to the reading of the report that the search went by; None without an episode.
    """

    report: str
    vehicle: int | None
    policy: str
    episodes: int
    scenario: Scenario | None
    outcome: str
    trial: CrashTestEpisode | None = None
    own: Judgement | None = None


@dataclass(frozen=True, slots=True)
class _Found:
    """The episode that is most like the described crash so far."""

    scenario: Scenario
    trial: CrashTestEpisode
    own: Judgement


def reproduce(role: CrashRole, policy: str, budget: int, seed: int = 0) -> CrashReproduction:
    """Search for the described crash; the same arguments give the same result.

    Draws, shifts the others in time so that they meet the ego where their tracks crossed, and changes what came near.
    The search goes by the reading of the report alone. It ends with the first episode in which nothing differs from it;
    else the result is the one with a contact in which the least differs.

    Args:
        role: the report, and the vehicle whose place the ego takes, if it takes one's.
        policy: name of the policy that drives the ego.
        budget: episodes at most; with 1, there is no search, only a draw.
        seed: of the search and of the simulator.
    """
    impossible = why_not_played(role.crash, role.ego)
    if impossible:
        return CrashReproduction(role.report, role.number, policy, 0, None, impossible)
    space = open_questions(role.crash)
    generator = generator_of(role, f"reproduce/{policy}/{seed}")
    best: tuple[float, Parameters, CrashTestEpisode] | None = None
    found: _Found | None = None
    said, nearest = "nobody came near", math.inf
    for episode in range(budget):
        drawn = _next(space, best, role, generator, fresh=episode % _FRESH == 0)
        try:
            scenario = build_scenario(role, drawn, f"{role.report}-{role.name}-{REPRODUCED}-{policy}", seed)
            trial = run_trial(scenario, policy)
        except RoadmendError as error:
            said = str(error)
            continue
        gap = math.inf if trial.summary.min_distance is None else trial.summary.min_distance
        if trial.contact is not None:
            crash = answer(role.crash, drawn)
            own = judge(trial.run, record_of(role.crash, lay_out(crash, drawn), role.ego or 0))
            if found is None or _weight(own) < _weight(found.own):
                found = _Found(scenario, trial, own)
            if own.is_reproduced:
                said = trial.summary.text
                return CrashReproduction(role.report, role.number, policy, episode + 1, scenario, said, trial, own)
            gap = _DIFFERENT * _weight(own)  # the wrong crash is a step to the right one if little of it is wrong
        elif math.isfinite(gap):
            nearest = min(nearest, gap)
            said = f"no contact; the nearest was {nearest:.1f} m"
            gap += _DIFFERENT
        if best is None or gap < best[0] or episode % _RESTART == 0:
            best = (gap, drawn, trial)
    if found is None:
        driven = 0 if best is None else budget  # none, where not one of the draws could be built and run
        return CrashReproduction(role.report, role.number, policy, driven, None, said)
    said = "; ".join(found.own.failed.values())
    name = plain_name(f"{role.report}-{role.name}-{NEAREST}-{policy}")  # a copy is not validated
    closest = found.scenario.model_copy(update={"name": name})
    return CrashReproduction(role.report, role.number, policy, budget, closest, said, found.trial, found.own)


def _weight(own: Judgement) -> float:
    """How far an episode is from the described crash: the other's parts may be one step off, the other people not."""
    return sum(_WEIGHTS.get(dimension, 1.0) for dimension in own.failed)


def _next(
    space: Space,
    best: tuple[float, Parameters, CrashTestEpisode] | None,
    role: CrashRole,
    generator: random.Random,
    *,
    fresh: bool,
) -> Parameters:
    """The next point: drawn anew, or the best one so far with the others shifted in time, or changed a little."""
    if best is None or fresh:
        return sample(space, generator)
    _, drawn, trial = best
    point = dict(drawn)
    aimed = False
    for index in range(len(role.crash.vehicles)):
        if role.ego is None or index == role.ego:  # who looks on shall not be met
            continue
        shift = _shift(trial, f"v{index + 1}")
        if shift is not None:
            name = f"v{index + 1}.delay"
            jitter = _JITTER if trial.contact is None else _OTHER_PART
            point[name] = round(float(point[name]) + shift + generator.gauss(0.0, jitter), 3)
            point[f"v{index + 1}.heed"] = "none"
            aimed = True
    moved = [name for name in space if generator.random() < (0.1 if aimed else 0.4)]
    return point | dict(_changed(space, point, moved, generator))


def _shift(trial: CrashTestEpisode, name: str) -> float | None:
    """Time [s] by which another vehicle would have to come later to meet the ego; None if their tracks do not cross."""
    other = trial.film.track(name)
    if not len(other):
        return None
    own = np.array([(ego.x, ego.y) for ego in trial.film.ego])
    gaps = np.hypot(own[:, None, 0] - other[None, :, 1], own[:, None, 1] - other[None, :, 2])
    meets = np.argwhere(gaps < _NEAR)
    if not len(meets):
        return None
    late = (meets[:, 0] - other[meets[:, 1], 0]) * INTERVAL
    return float(late[np.argmin(np.abs(late))])


def _changed(
    space: Space, point: Parameters, names: list[str], generator: random.Random
) -> Iterator[tuple[str, float | int | str | bool]]:
    for name in names:
        dimension = space[name]
        if isinstance(dimension, Uniform):
            width = dimension.high - dimension.low
            value = float(point[name]) + generator.gauss(0.0, _STEP * width)
            yield name, round(min(max(value, dimension.low), dimension.high), 3)
        elif generator.random() < 0.3:
            yield name, dimension.sample(generator)
