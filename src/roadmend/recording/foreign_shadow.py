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
from roadmend.recording.foreign_parameters import PATIENCE_S
from roadmend.recording.foreign_repair import Answer, ForeignRepair
from roadmend.recording.reader import BagReader
from roadmend.recording.shadow import ShadowComparison, ShadowSummary
from roadmend.recording.ticks import LATE_NS
from roadmend.recording.topics import REPAIR_STATE, TYPES, own
from roadmend.repair.guard import GuardedRepairer

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
    patience: float = PATIENCE_S,
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
        patience: [s] of the bag's time after which an input counts as late.

    Raises:
        InputError: a topic is missing or of the wrong type, the bag is corrupt, or holds no command.
    """
    found = topics.by_input(reader)
    kinds = {name: reader.topics[topic].type_name for name, topic in found.items()}
    form = COMMAND_FORMS[kinds[foreign_repair.COMMAND]](pedals)
    repair = ForeignRepair(vehicle, OBJECT_READERS[kinds[foreign_repair.OBJECTS]](), form, patience)
    repair.use(repairer)
    comparison, speed = ShadowComparison(), 0.0
    states = state_topics(reader)
    pairing = _Pairing(comparison)
    takers: Mapping[str, Callable[[Any, float], None]] = {
        foreign_repair.EGO: repair.take_ego,
        foreign_repair.OBJECTS: repair.take_objects,
        foreign_repair.TRAJECTORY: repair.take_trajectory,
        foreign_repair.ROUTE: lambda message, _now: repair.take_route(message),
    }
    inputs = {topic: name for name, topic in found.items()}
    for message in reader.messages([*inputs, *states]):
        now = 1e-9 * message.time_ns
        if message.topic in states:
            pairing.tell(messages.stamp_of(message.value.header), now, message.value)
            continue
        name = inputs[message.topic]
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
            pairing.judge(answer.stamp, _Judged(now, form.read(message.value), answer.repair, speed))
            watcher(message.time_ns, answer)
    pairing.close()
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


class _Pairing:
    """Brings what was done to the answer of the other method with the same stamp, whichever stands first in the bag.

    Commands without a stamp have the odometry's, and so have their states, which may lie before them.
    """

    def __init__(self, comparison: ShadowComparison) -> None:
        self._comparison = comparison
        self._judged: dict[int, _Judged] = {}  # by stamp [ns], until it is known what was done
        self._told: dict[int, tuple[float, Any]] = {}  # likewise the log time [s] and state, until it has been judged

    def judge(self, stamp: int, judged: _Judged) -> None:
        """Take in an answer of the other method."""
        self._let_go(judged.time)
        if stamp in self._told:
            self._add(judged, self._told.pop(stamp)[1])
        else:
            self._leave(stamp)
            self._judged[stamp] = judged

    def tell(self, stamp: int, now: float, state: Any) -> None:
        """Take in what a repair node did, at the log time ``now`` [s]."""
        self._let_go(now)
        if stamp in self._judged:
            self._add(self._judged.pop(stamp), state)
        else:
            self._told[stamp] = now, state

    def close(self) -> None:
        """Of what is left nobody has told that it was changed."""
        for stamp in [*self._judged]:
            self._leave(stamp)

    def _let_go(self, now: float) -> None:
        late = now - 1e-9 * LATE_NS
        for stamp in [stamp for stamp, judged in self._judged.items() if judged.time < late]:
            self._leave(stamp)
        for stamp in [stamp for stamp, (then, _) in self._told.items() if then < late]:
            del self._told[stamp]

    def _leave(self, stamp: int) -> None:
        if stamp in self._judged:
            self._comparison.add(*self._judged.pop(stamp), intervened=False)

    def _add(self, judged: _Judged, state: Any) -> None:
        self._comparison.add(*judged.repaired(state.final_action), intervened=state.intervened)


def state_topics(reader: BagReader) -> list[str]:
    """The topic on which the graph's repair node told what it did, if there is one."""
    kind = TYPES[REPAIR_STATE]
    name = own(name for name, topic in reader.topics.items() if topic.type_name == kind)
    return [] if name is None else [name]
