"""A recorded episode as tables of pandas."""

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any

from roadmend.core.appearance import kind_of
from roadmend.core.extras import extra_missing
from roadmend.core.repair import Repair
from roadmend.core.scene import COLUMNS
from roadmend.recording.episode import read_episode

try:
    import pandas as pd
except ModuleNotFoundError as error:
    raise extra_missing(error) from None

_EGO = ("x", "y", "yaw", "speed", "yaw_rate")
_REPAIR = ("policy_action", "final_action", "repair_action", "score", "threshold", "worth", "intervened", "reason")


class BagTables:
    """What a bag tells of its episode; each table is made when it is asked for.

    Units are SI: times [s] of simulation, places [m] and headings [rad] in the frame of the map, counter-clockwise from
    east. What a bag does not hold is NaN, or an empty table.

    Attributes:
        path: of the bag.
        account: what the bag says of the run: scenario, policy, method, versions, outcome.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._episode = read_episode(path)
        self.account: Mapping[str, str] = self._episode.account

    @cached_property
    def ticks(self) -> pd.DataFrame:
        """One row a tick, by its time.

        The ego's x, y [m], yaw [rad], speed [m/s] and yaw_rate [rad/s]; status of the repair, and of the command, as
        throttle - brake in -1 .. 1, policy_action, repair_action (proposed) and final_action (driven); score and
        threshold of the method; worth, where it judges one; intervened; reason, for people.
        """
        episode = self._episode
        rows = []
        for stamp in episode.stamps:
            ego, repair = episode.ego[stamp], episode.repairs.get(stamp)
            rows.append([stamp * 1e-9, *(getattr(ego, name) for name in _EGO), *_answer(repair)])
        return _by_time(rows, ["time", *_EGO, "status", *_REPAIR])

    @cached_property
    def objects(self) -> pd.DataFrame:
        """One row for each participant at each tick, by time and id.

        kind in words; x, y [m] of the centre, yaw [rad], speed [m/s] and acceleration [m/s2] along it, yaw_rate
        [rad/s], length and width [m].
        """
        tables = []
        for stamp, objects in sorted(self._episode.objects.items()):
            table = pd.DataFrame({name: objects.table[name] for name in COLUMNS})
            table["kind"] = [kind_of(int(kind)).name for kind in objects.kind]
            table.insert(0, "time", stamp * 1e-9)
            tables.append(table)
        whole = pd.concat(tables) if tables else pd.DataFrame(columns=["time", *COLUMNS])
        return whole.set_index(["time", "id"])

    @cached_property
    def interventions(self) -> pd.DataFrame:
        """One row for each uninterrupted row of ticks at which the command was replaced.

        begin and duration [s]; ticks; dose, seconds of full command by which the drive was changed; strongest, the
        least throttle - brake that was driven; worth, in prices of a collision, where the method judges one; because_of,
        the ids of those that made it step in, the weightiest first; and why, at its first tick, in words.
        """
        rows = []
        for account in self._episode.spells():
            plain = account.as_dict()
            ids = [sight["id"] for sight in plain.pop("triggers")]
            rows.append(plain | {"because_of": ids, "why": plain.pop("reason")})
        names = ["begin", "duration", "ticks", "dose", "strongest", "worth", "because_of", "why"]
        return pd.DataFrame(rows, columns=names)

    @cached_property
    def events(self) -> pd.DataFrame:
        """One row for each thing that happened: time [s], kind and text.

        Of a collision also with_whom, blame, at_fault, and impact_speed [m/s] of the ego.
        """
        names = ["time", "kind", "text", "with_whom", "blame", "at_fault", "impact_speed"]
        rows = [
            [
                event.time,
                event.kind.name,
                event.text,
                [*event.object_names],
                event.blame.name,
                event.at_fault,
                event.impact_speed,
            ]
            for event in self._episode.events
        ]
        return pd.DataFrame(rows, columns=names)


def read_bag(path: str | PathLike[str]) -> BagTables:
    """Read the one episode that a bag holds; needs no ROS.

    Args:
        path: a bag's folder, or an MCAP file by itself.

    Raises:
        InputError: there is no such bag, it is cut short, holds no ego, or pandas is not installed.
    """
    return BagTables(Path(path))


def _answer(repair: Repair | None) -> Iterable[Any]:
    if repair is None:
        return ["", *[math.nan] * (len(_REPAIR) - 2), False, ""]
    values = [getattr(repair, name) for name in _REPAIR]
    return [repair.status.name, *(math.nan if value is None else value for value in values)]


def _by_time(rows: Sequence[Sequence[Any]], names: Sequence[str]) -> pd.DataFrame:
    return pd.DataFrame(rows, columns=[*names]).set_index("time")
