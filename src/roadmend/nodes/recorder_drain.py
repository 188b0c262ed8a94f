"""What a recorder that was told to stop still takes in: everything that was sent before, as far as DDS can bring it.

A message that got lost on the way blocks all that its publisher sent after it, until DDS has noticed and repaired the loss:
Fast DDS looks every 3 s, and what it then sends again in one burst may get lost again. So what counts is when a message was
sent, not for how long messages come: publishers that go on would keep the bag open for ever, and a limit on time alone cuts
off between two repairs.
"""

import time
from collections.abc import Callable, Iterable
from typing import Any

LOOK_S = 0.02  # [s] between two looks
QUIET_S = 0.2  # [s] without a message after which nothing more is expected of publishers that have gone
REPAIR_S = 3.3  # [s] the same for publishers that are there: Fast DDS repairs a loss every 3 s

Callback = Callable[[bytes], None]


def drain(subscriptions: Iterable[tuple[Any, Callback]], has_others: Callable[[], bool], limit: float) -> bool:
    """Take messages until nothing that was sent before this call is expected any more.

    Args:
        subscriptions: each with what takes its serialized messages; nobody else may spin their node meanwhile.
        has_others: whether a publisher of another node is still there.
        limit: [s] of wall time after which it ends in any case.

    Returns:
        Whether they had ceased to come; False where messages sent before were still coming at the limit.
    """
    subscriptions = list(subscriptions)
    told_ns = time.time_ns()
    began = newest = now = time.monotonic()
    looks = 0  # since the newest message
    while (now := time.monotonic()) - began < limit:
        # What was sent later is recorded too, but nobody waits for it. It counts as many as it can: all must be called.
        if sum([_take(subscription, callback, told_ns) for subscription, callback in subscriptions]):
            newest, looks = now, 0
        patience = REPAIR_S if has_others() else QUIET_S
        # Time alone does not tell: on a busy machine this process may not have been let look meanwhile.
        if now - newest >= patience and looks * LOOK_S >= patience:
            return True
        time.sleep(LOOK_S)
        looks += 1
    return now - newest > QUIET_S


def _take(subscription: Any, callback: Callback, told_ns: int) -> int:
    """Take all that is there; how many of them were sent until then, by the wall clock of their publisher [ns]."""
    owed = 0
    with subscription.handle:
        while (taken := subscription.handle.take_message(subscription.msg_type, True)) is not None:
            data, info = taken
            callback(data)
            owed += info["source_timestamp"] <= told_ns
    return owed
