"""What the repair node did: its states one after another, how much it changed, and whether that was in time."""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from roadmend.core.geometry import outline_distances
from roadmend.core.outcome import Blame
from roadmend.core.repair import Interventions, Repair, RepairStatus
from roadmend.core.tick import INTERVAL
from roadmend.recording.episode import BagEpisode
from roadmend.sera.incident import RepairAccount, Verdict
from roadmend.world.ego import STANDING

WATCHED = 8.0  # [s] before a failure
PAUSE = 0.5  # [s] after which the next intervention is another one
SILENT = "SILENT"  # no word of the node at a tick
NONE = "none"  # the method that never steps in
_HELD = 0.5  # share of the last seconds before a time-out that the ego must have been held by the node
_CLOSE = 1.0  # [m]
_NEAR = 10.0  # [m] gap up to which distances are exact
_BEHIND = frozenset({Blame.EGO_STOOD, Blame.REAR})
_FAULTS = frozenset(status.name for status in RepairStatus) - {"PASS", "REPAIRED", "RESET"}


@dataclass(frozen=True, slots=True)
class Intervention:
    """Ticks whose command was replaced, with pauses of at most PAUSE."""

    begin: int  # [ns] stamp of the first
    end: int  # [ns] stamp of the last


def interventions_of(episode: BagEpisode) -> Iterator[Intervention]:
    """All interventions of an episode, in order; neither the hold before the start nor an answer to the final tick."""
    last = episode.stamps[-1]
    stamps = [
        stamp
        for stamp, repair in sorted(episode.repairs.items())
        if repair.intervened and repair.status != RepairStatus.STARTING and stamp < last
    ]
    begin = end = None
    for stamp in stamps:
        if begin is None or end is None:
            begin = stamp
        elif stamp - end > PAUSE * 1e9:
            yield Intervention(begin, end)
            begin = stamp
        end = stamp
    if begin is not None and end is not None:
        yield Intervention(begin, end)


def account_of_failure(episode: BagEpisode, time: int, blame: Blame, avoidable: float | None) -> RepairAccount:
    """What was done in the seconds before a collision.

    Args:
        episode: in which it happened.
        time: when, [ns].
        blame: the kind of contact.
        avoidable: [s] before the contact at which braking fully would have been enough; None if never.
    """
    account = _account(episode, round(time - WATCHED * 1e9), time)
    return _with(account, _before_contact(account, time * 1e-9, blame, avoidable))


def account_of_standstill(episode: BagEpisode, time: int) -> RepairAccount:
    """What was done in the seconds before a time-out or the end of the lane."""
    account = _account(episode, round(time - WATCHED * 1e9), time)
    held = sum(
        repair.intervened and repair.policy_action > 0.0 and episode.ego[stamp].speed < STANDING
        for stamp, repair in _between(episode, round(time - WATCHED * 1e9), time)
        if stamp in episode.ego
    )
    verdict: Verdict = "held_the_ego" if held * INTERVAL > _HELD * WATCHED else "not_involved"
    return _with(account, verdict if _is_at_work(account) else "no_method")


def account_of_intervention(episode: BagEpisode, intervention: Intervention, plan_gap: float | None) -> RepairAccount:
    """What was done in an intervention, and whether the policy's plan asked for it.

    Args:
        episode: in which it happened.
        intervention: when.
        plan_gap: see ``plan_gap``.
    """
    account = _account(episode, intervention.begin, intervention.end)
    states = {state for state, _ in account.states}
    verdict: Verdict
    if states & _FAULTS:
        verdict = "controlled_stop"
    elif plan_gap is not None and plan_gap <= 0.0:
        verdict = "needed"
    else:
        verdict = "close" if plan_gap is not None and plan_gap < _CLOSE else "no_need_seen"
    return _with(account, verdict, plan_gap)


def plan_gap(episode: BagEpisode, stamp: int) -> tuple[float, int] | None:
    """The least gap [m] on the policy's plan of a tick to the others as they were recorded, and to whom.

    Who was behind the ego's rear at the beginning is left out. An estimate: in the recording the others have seen the
    repaired ego, not the one that follows its plan. None where the bag holds no plan or nobody is around.
    """
    plan, ego = episode.trajectories.get(stamp), episode.ego.get(stamp)
    if plan is None or ego is None or not len(plan):
        return None
    times = np.arange(len(plan) + 1) * plan.interval
    xs, ys = np.concatenate([[ego.x], plan.x]), np.concatenate([[ego.y], plan.y])
    yaws = np.unwrap(np.concatenate([[ego.yaw], plan.yaw]))
    now = episode.objects.get(stamp)
    behind = set()
    if now is not None:
        along = (now.x - ego.x) * np.cos(ego.yaw) + (now.y - ego.y) * np.sin(ego.yaw)
        behind = set(now.id[along < -0.5 * (ego.length + now.length)].tolist())
    best: tuple[float, int] | None = None
    for later in episode.stamps:
        ahead = (later - stamp) * 1e-9
        objects = episode.objects.get(later)
        if objects is None or not 0.0 <= ahead <= times[-1] or not len(objects):
            continue
        x, y, yaw = (float(np.interp(ahead, times, column)) for column in (xs, ys, yaws))
        gaps = outline_distances(ego._replace(x=x, y=y, yaw=yaw), objects.table, _NEAR)
        gaps[[number in behind for number in objects.id.tolist()]] = np.inf
        index = int(np.argmin(gaps))
        if np.isfinite(gaps[index]) and (best is None or gaps[index] < best[0]):
            best = max(0.0, float(gaps[index])), int(objects.id[index])
    return best


def _before_contact(account: RepairAccount, time: float, blame: Blame, avoidable: float | None) -> Verdict:
    if not _is_at_work(account):
        return "no_method"
    if account.begin is None:
        return "not_at_all"
    if blame in _BEHIND:
        return "struck_while_braking"
    return "too_late" if avoidable is None or account.begin > time - avoidable + 1e-6 else "too_weak"


def _is_at_work(account: RepairAccount) -> bool:
    return account.method != NONE and any(state != SILENT for state, _ in account.states)


def _account(episode: BagEpisode, begin: int, end: int) -> RepairAccount:
    stamps = [stamp for stamp in episode.stamps if begin <= stamp <= end]
    names = [episode.repairs[stamp].status.name if stamp in episode.repairs else SILENT for stamp in stamps]
    if stamps and stamps[-1] == episode.stamps[-1] and len(names) > 1 and names[-1] == SILENT:
        names.pop()  # nobody answers the final tick
    replaced = [(stamp, repair) for stamp, repair in _between(episode, begin, end) if repair.intervened]
    done = Interventions()
    for _, repair in replaced:
        done.add(repair)
    return RepairAccount(
        "not_involved",
        episode.account.get("method", ""),
        tuple((name, round(len(list(run)) * INTERVAL, 2)) for name, run in itertools.groupby(names)),
        round(replaced[0][0] * 1e-9, 3) if replaced else None,
        done.ticks,
        round(done.dose, 4),
    )


def _between(episode: BagEpisode, begin: int, end: int) -> Sequence[tuple[int, Repair]]:
    return [(stamp, episode.repairs[stamp]) for stamp in sorted(episode.repairs) if begin <= stamp <= end]


def _with(account: RepairAccount, verdict: Verdict, gap: float | None = None) -> RepairAccount:
    return replace(account, verdict=verdict, plan_gap=None if gap is None else round(gap, 2))
