"""Offers as ROS has them and as bags record them."""

import pytest

from roadmend.nodes import qos
from roadmend.nodes.qos import offer_from, profile_of
from roadmend.recording.qos import INFINITE_NS, Qos


@pytest.mark.parametrize(
    "offer",
    [
        Qos(),
        Qos(depth=1, durability="transient_local", deadline_ns=500_000_000, lifespan_ns=10**9),
        Qos(reliability="best_effort", liveliness="manual_by_topic", liveliness_lease_ns=10**9),
        Qos(history="keep_all", depth=0),
    ],
)
def test_what_is_recorded_is_offered_again(offer):
    assert offer_from(profile_of(offer)) == offer


def test_what_a_recorder_could_not_see_gets_the_default():
    profile = profile_of(Qos(history="unknown", depth=7, reliability="unknown", liveliness="system_default"))
    assert offer_from(profile) == Qos(depth=7)


def test_a_publishers_own_profile_reads_as_dds_would_tell_it():
    assert offer_from(qos.COMMAND) == Qos(depth=1, deadline_ns=500_000_000)
    assert offer_from(qos.STREAM).lifespan_ns == INFINITE_NS
