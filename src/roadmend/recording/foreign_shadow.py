"""What a repair method would have done at every command of a bag that another stack recorded. Open loop, needs no ROS."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any, NamedTuple

from roadmend.core.command import Command
from roadmend.core.errors import InputError
from roadmend.core.repair import Repair
from roadmend.recording import foreign_repair, messages
from roadmend.recording.foreign_commands import COMMAND_FORMS, Pedals
from roadmend.recording.foreign_objects import OBJECT_READERS, EgoOutline
from roadmend.recording.foreign_repair import Answer, ForeignRepair
from roadmend.recording.reader import BagReader
from roadmend.recording.shadow import ShadowComparison, ShadowSummary
from roadmend.recording.topics import REPAIR_STATE, TYPES, own
from roadmend.repair.guard import GuardedRepairer

PATIENCE_S = 0.3  # [s] of the bag's time after which an input counts as late
_TYPES = {  # of each input: those that can be read
    foreign_repair.EGO: (messages.EGO.name,),
    foreign_repair.OBJECTS: tuple(OBJECT_READERS),
    foreign_repair.COMMAND: tuple(COMMAND_FORMS),
    foreign_repair.TRAJECTORY: (messages.TRAJECTORY.name,),
    foreign_repair.ROUTE: (messages.ROUTE.name,),
}


@dataclass(frozen=True, slots=True)
class ForeignTopics:
    """Where a bag has what repair looks at."""

    ego: str
    objects: str
    command: str
    trajectory: str = ""  # empty where there is none
    route: str = ""

    def by_input(self, reader: BagReader) -> dict[str, str]:
        """Input -> topic, of those that are there.

        Raises:
            InputError: the bag lacks one, or has it of a type that cannot be read.
        """
        given = {
            foreign_repair.EGO: self.ego,
            foreign_repair.OBJECTS: self.objects,
            foreign_repair.COMMAND: self.command,
            foreign_repair.TRAJECTORY: self.trajectory,
            foreign_repair.ROUTE: self.route,
        }
        for name, topic in given.items():
            if topic or name in foreign_repair.NEEDED:
                check_topic(reader, name, topic)
        return {name: topic for name, topic in given.items() if topic}


def check_topic(reader: BagReader, name: str, topic: str) -> None:
    """See whether a bag has an input on a topic.

    Raises:
        InputError: it does not, or of a type that cannot be read; names those that fit.
    """
    if not topic:
        raise InputError(f"--{name}", "is not given", f"name one of {_choices(reader, name)}")
    if topic not in reader.topics:
        near = get_close_matches(topic, reader.topics, 1)
        hint = f"did you mean {near[0]}?" if near else f"name one of {_choices(reader, name)}"
        raise InputError(f"--{name} {topic}", f"is not in {reader.path}", hint)
    kind = reader.topics[topic].type_name
    if kind not in _TYPES[name]:
        wanted = " or ".join(_TYPES[name])
        raise InputError(f"--{name} {topic}", f"is {kind}, not {wanted}", f"name one of {_choices(reader, name)}")


def _choices(reader: BagReader, name: str) -> str:
    fitting = [topic.name for topic in reader.topics.values() if topic.type_name in _TYPES[name]]
    return ", ".join(fitting) or f"{' or '.join(_TYPES[name])}: the bag holds none"


def run_foreign_shadow(
    reader: BagReader,
    topics: ForeignTopics,
    repairer: GuardedRepairer,
    vehicle: EgoOutline,
    pedals: Pedals,
    watcher: Callable[[int, Answer], None] = lambda _time, _answer: None,
) -> ShadowSummary:
    """Let a method judge every recorded command, with the newest odometry and objects before it in the bag.

    Messages arrive at their log times. What was done is what a repair node of roadmend sent, where its states are in the bag
    (``roadmend repair`` records them), else what was asked.

    Args:
        reader: the bag.
        topics: where it has the inputs.
        repairer: the method behind its guard.
        vehicle: what odometry does not tell.
        pedals: what its pedals do, where commands are accelerations.
        watcher: called with the log time [ns] of each command and the answer to it.

    Raises:
        InputError: a topic is missing or of the wrong type, the bag is corrupt, or holds no command.
    """
    found = topics.by_input(reader)
    kinds = {name: reader.topics[topic].type_name for name, topic in found.items()}
    form = COMMAND_FORMS[kinds[foreign_repair.COMMAND]](pedals)
    repair = ForeignRepair(vehicle, OBJECT_READERS[kinds[foreign_repair.OBJECTS]](), form, PATIENCE_S)
    repair.use(repairer)
    comparison, speed = ShadowComparison(), 0.0
    states = state_topics(reader)
    judged: _Judged | None = None  # the last answer, until it is known what was done
    takers: Mapping[str, Callable[[Any, float], None]] = {
        foreign_repair.EGO: repair.take_ego,
        foreign_repair.OBJECTS: repair.take_objects,
        foreign_repair.TRAJECTORY: repair.take_trajectory,
        foreign_repair.ROUTE: lambda message, _now: repair.take_route(message),
    }
    inputs = {topic: name for name, topic in found.items()}
    for message in reader.messages([*inputs, *states]):
        if message.topic in states:
            if judged is not None:
                done = judged.repaired(message.value.final_action)
                comparison.add(*done, intervened=message.value.intervened)
                judged = None
            continue
        name, now = inputs[message.topic], 1e-9 * message.time_ns
        try:
            if name != foreign_repair.COMMAND:
                takers[name](message.value, now)
                if name == foreign_repair.EGO:
                    speed = message.value.twist.twist.linear.x
                continue
        except ValueError as error:
            raise InputError(
                str(reader.path), f"{message.topic} at {now:.2f} s: {error}", "take another bag"
            ) from error
        answer = repair.take_command(message.value, now)
        if answer is not None:
            if judged is not None:
                comparison.add(*judged, intervened=False)
            judged = _Judged(now, form.read(message.value), answer.repair, speed)
            watcher(message.time_ns, answer)
    if judged is not None:
        comparison.add(*judged, intervened=False)
    if not comparison.count:
        raise InputError(str(reader.path), f"holds no message on {topics.command}", "name the topic of the commands")
    return comparison.summary(is_repaired=bool(states))


class _Judged(NamedTuple):
    """An answer of the other method, and what was done instead: what ``ShadowComparison.add`` takes."""

    time: float  # [s]
    done: Command
    answer: Repair
    speed: float  # [m/s]

    def repaired(self, action: float) -> "_Judged":
        """The same where ``action``, throttle - brake, was sent."""
        return self._replace(done=Command.from_action(action))


def state_topics(reader: BagReader) -> list[str]:
    """The topic on which the graph's repair node told what it did, if there is one."""
    kind = TYPES[REPAIR_STATE]
    found = [name for name, topic in reader.topics.items() if topic.type_name == kind]
    return [own(found)] if found else []
