"""What reading through a file brought to light."""

from collections import Counter
from dataclasses import dataclass, field

_DAMAGES_TOLD = 20


@dataclass(slots=True)
class ScanReport:
    """What a scan has come upon; complete once the scan is over."""

    has_end: bool = False  # an index and the closing mark
    messages: Counter[str] = field(default_factory=Counter)  # by topic
    expected: Counter[str] | None = None  # the same by the file's own statistics, where they are left
    left_out: dict[str, str] = field(default_factory=dict)  # topics that are none of ROS 2, and why
    nameless: int = 0  # messages whose topic is not known
    damages: list[str] = field(default_factory=list)
    damage_count: int = 0

    @property
    def _lost(self) -> Counter[str]:
        return (self.expected or Counter()) - self.messages

    @property
    def missing(self) -> list[str]:
        """Lines for people: what is wrong with the file."""
        lines = [] if self.has_end else ["the file has no end: its writer was stopped, or the file was cut"]
        lines += self.damages
        if self.damage_count > len(self.damages):
            lines.append(f"{self.damage_count - len(self.damages)} further places are damaged")
        if self.nameless:
            lines.append(f"{self.nameless} messages belong to no topic that can still be named")
        lines += [
            f"{topic}: {count} of {count + self.messages[topic]} messages are lost"
            for topic, count in sorted(self._lost.items())
        ]
        lines += [f"{topic}: left out, {why}" for topic, why in sorted(self.left_out.items())]
        return lines

    def add(self, damage: str) -> None:
        """Note one damage."""
        self.damage_count += 1
        if len(self.damages) < _DAMAGES_TOLD:
            self.damages.append(damage)
