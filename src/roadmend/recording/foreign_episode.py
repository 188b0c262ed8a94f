"""A drive of another stack as an episode, for pictures: what was newest at every answer of a repair node. Needs no ROS."""

import contextlib
from pathlib import Path

from roadmend.core.errors import InputError
from roadmend.core.scene import ObjectList
from roadmend.recording import messages
from roadmend.recording.episode import BagEpisode
from roadmend.recording.foreign_objects import OBJECT_READERS, EgoOutline, EgoPose, ego_pose_of
from roadmend.recording.foreign_repair import EGO, OBJECTS
from roadmend.recording.foreign_shadow import check_topic, state_topics
from roadmend.recording.layout import RECORD
from roadmend.recording.reader import BagReader


def read_foreign_episode(path: Path, ego: str, objects: str, vehicle: EgoOutline) -> BagEpisode:
    """Read a bag that another stack recorded, or ``roadmend repair`` beside it.

    A tick is an answer of the repair node, with the newest odometry and objects before it in the bag; where the bag holds
    no answers, a tick is an odometry message. Of lanes, a route and a plan nothing is known.

    Args:
        path: the bag's folder or its .mcap file.
        ego: topic of the odometry.
        objects: topic of the objects.
        vehicle: what odometry does not tell.

    Raises:
        InputError: the bag is unusable, a topic is missing or of the wrong type, or there is no tick.
    """
    reader = BagReader(path)
    for name, topic in ((EGO, ego), (OBJECTS, objects)):
        check_topic(reader, name, topic)
    seeing = OBJECT_READERS[reader.topics[objects].type_name]()
    states = state_topics(reader)
    episode = BagEpisode(reader.path, account=reader.metadata.get(RECORD, {}))
    pose: EgoPose | None = None
    seen: ObjectList | None = None
    for message in reader.messages([ego, objects, *states]):
        stamp = messages.stamp_of(message.value.header) or message.time_ns
        try:
            if message.topic == ego:
                pose = ego_pose_of(message.value, vehicle)
            elif message.topic == objects:
                with contextlib.suppress(ValueError):  # as the repair node has met it: what was seen before still holds
                    seen = seen if pose is None else seeing.read(message.value, pose)[0]
            elif pose is not None:
                episode.repairs[stamp] = messages.repair_of(message.value)
        except ValueError as error:
            where = f"{message.topic} at {1e-9 * message.time_ns:.2f} s"
            raise InputError(str(path), f"{where}: {error}", "take another bag, or other topics") from error
        if pose is None or message.topic != (states[0] if states else ego):
            continue
        episode.ego[stamp] = pose.ego
        if seen is not None:
            episode.objects[stamp] = seen
    if not episode.ego:
        raise InputError(str(path), f"holds nothing on {ego} before an answer", "name the topic of the ego's odometry")
    return episode
