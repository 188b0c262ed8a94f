"""Waiting as often and as long as a method did, whatever the scene."""

from harness.shuffle import BlockPlayer
from harness.waits import WaitPlayer, Waits
from roadmend.core.command import Command, Decision, Trajectory


def watched(text):
    """Requests of a drive: h held back, g granted, . nothing asked."""
    waits = Waits()
    for tick in text:
        waits.watch(asks=tick != ".", held=tick == "h")
    return waits


def test_a_request_lasts_until_it_is_granted_or_given_up():
    waits = watched("..hhhg..g.hh..g")
    assert (waits.requests, waits.lengths) == (4, [3, 2])


def test_each_granted_tick_is_a_request_of_its_own():
    assert watched("ggg").requests == 3


def test_it_holds_back_as_often_and_as_long():
    waits = watched("hhhg" + ".g" * 3)
    held = lengths = 0
    for number in range(400):
        player = waits.player(str(number))
        times = [player.holds(asks=True) for _ in range(4)]
        if times[0]:
            held += 1
            lengths += times.index(False) if False in times else 4
    assert 60 < held < 140
    assert lengths / held < 3.7  # three ticks, and now and then it is held again


def test_what_nobody_held_back_nobody_holds():
    assert not WaitPlayer.idle().holds(asks=True)
    assert not watched("gg.g").player("x").holds(asks=True)


def test_a_request_that_is_given_up_is_drawn_anew():
    player = watched("hhhhg").player("x")
    assert player.holds(asks=True)
    assert not player.holds(asks=False)
    assert player.holds(asks=True)


def test_the_shuffle_holds_back_what_is_drawn_and_moves_no_pedal():
    player = BlockPlayer([], watched("h").player("x"))
    player.reset(None)
    asked = Decision(Command.from_action(0.3, change_lane=True), Trajectory.empty())
    repair = player.step(None, asked)
    assert repair.held_back
    assert not repair.command.change_lane
    assert (repair.change, repair.final_action) == (0.0, asked.command.action)
    assert not BlockPlayer([]).step(None, asked).held_back
