"""Quality of service as bags record it, so that a player can offer what the recorded publishers offered."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Any

import yaml
from rosbags.interfaces import Qos as RosbagsQos
from rosbags.interfaces import QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

from roadmend.core.bounds import ARGUMENT
from roadmend.core.yaml_file import parse_yaml

INFINITE_NS = 2**63 - 1  # [ns] how ROS writes "no limit"
_SECOND = 1_000_000_000


@dataclass(frozen=True, slots=True)
class Qos:
    """One publisher's offer. Policies have the names that rmw gives them, in lower case."""

    history: str = "keep_last"
    depth: int = 10
    reliability: str = "reliable"
    durability: str = "volatile"
    deadline_ns: int = INFINITE_NS
    lifespan_ns: int = INFINITE_NS
    liveliness: str = "automatic"
    liveliness_lease_ns: int = INFINITE_NS
    avoid_ros_namespace_conventions: bool = False

    @property
    def is_latched(self) -> bool:
        """Whether a late joiner gets what was sent before."""
        return self.durability == "transient_local"

    @property
    def keeps_all(self) -> bool:
        """Whether the depth has no meaning."""
        return self.history == "keep_all"

    def as_yaml(self) -> dict[str, Any]:
        """The offer in the shape that rosbag2 writes from bag version 9 on."""
        return {
            "history": self.history,
            "depth": self.depth,
            "reliability": self.reliability,
            "durability": self.durability,
            "deadline": _parts(self.deadline_ns),
            "lifespan": _parts(self.lifespan_ns),
            "liveliness": self.liveliness,
            "liveliness_lease_duration": _parts(self.liveliness_lease_ns),
            "avoid_ros_namespace_conventions": self.avoid_ros_namespace_conventions,
        }

    @classmethod
    def from_yaml(cls, shape: dict[str, Any]) -> "Qos":
        """The inverse of ``as_yaml``. Takes the numbers of bag version 8 and before, too.

        Raises:
            KeyError, TypeError, ValueError: the shape is another one.
        """
        return cls(
            _name(shape["history"], QosHistory),
            int(shape["depth"]),
            _name(shape["reliability"], QosReliability),
            _name(shape["durability"], QosDurability),
            _whole(shape["deadline"]),
            _whole(shape["lifespan"]),
            _name(shape["liveliness"], QosLiveliness),
            _whole(shape["liveliness_lease_duration"]),
            bool(shape["avoid_ros_namespace_conventions"]),
        )


def to_rosbags(offer: Qos) -> RosbagsQos:
    """The offer as the library rosbags has it."""
    times = [QosTime(*divmod(ns, _SECOND)) for ns in (offer.deadline_ns, offer.lifespan_ns, offer.liveliness_lease_ns)]
    return RosbagsQos(
        QosHistory[offer.history.upper()],
        offer.depth,
        QosReliability[offer.reliability.upper()],
        QosDurability[offer.durability.upper()],
        times[0],
        times[1],
        QosLiveliness[offer.liveliness.upper()],
        times[2],
        offer.avoid_ros_namespace_conventions,
    )


def from_rosbags(offer: RosbagsQos) -> Qos:
    """The inverse of ``to_rosbags``."""
    return Qos(
        offer.history.name.lower(),
        offer.depth,
        offer.reliability.name.lower(),
        offer.durability.name.lower(),
        _nanoseconds(offer.deadline),
        _nanoseconds(offer.lifespan),
        offer.liveliness.name.lower(),
        _nanoseconds(offer.liveliness_lease_duration),
        offer.avoid_ros_namespace_conventions,
    )


def _nanoseconds(duration: QosTime) -> int:
    return int(duration.sec * _SECOND + duration.nsec)


def dump(profiles: Iterable[Qos]) -> str:
    """The text of ``offered_qos_profiles`` in a channel's metadata; empty without profiles."""
    shapes = [profile.as_yaml() for profile in profiles]
    return yaml.safe_dump(shapes, sort_keys=False).rstrip("\n") if shapes else ""


@cache  # the channels of a bag share few texts, and YAML is slow to read
def load(text: str) -> tuple[Qos, ...]:
    """The offers from the text of ``offered_qos_profiles``.

    Raises:
        InputError, KeyError, TypeError, ValueError: the text is not what ``dump`` writes.
    """
    return tuple(Qos.from_yaml(shape) for shape in parse_yaml(text, "offered_qos_profiles", ARGUMENT) or ())


def _name(policy: str | int, numbered: type[Enum]) -> str:
    if isinstance(policy, int):
        return numbered(policy).name.lower()
    if str(policy).upper() not in numbered.__members__ or str(policy) != str(policy).lower():
        raise ValueError(f"{str(policy)[:40]!r} is no quality of service")
    return str(policy)


def _parts(nanoseconds: int) -> dict[str, int]:
    return {"sec": nanoseconds // _SECOND, "nsec": nanoseconds % _SECOND}


def _whole(parts: dict[str, int]) -> int:
    return int(parts["sec"]) * _SECOND + int(parts["nsec"])  # a text times a second would fill the memory
