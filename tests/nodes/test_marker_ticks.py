"""When to draw, and of what."""

from roadmend.nodes.marker_ticks import Cadence, TickMemory


def test_memory_pairs_by_stamp_and_forgets_the_future() -> None:
    memory = TickMemory(("ego", "objects"), depth=3)
    packets = [b"\x00\x01\x00\x00" + bytes([tick, 0, 0, 0, 0, 0, 0, 0]) for tick in range(6)]
    for packet in packets:
        memory.put("ego", packet)
    assert memory.newest("ego") == 5_000_000_000
    assert memory.newest("objects") is None
    assert memory.at("ego", 4_000_000_000) == packets[4]
    assert memory.at("ego", 1_000_000_000) is None
    memory.drop_after(3_000_000_000)
    assert memory.newest("ego") == 3_000_000_000


def test_cadence_draws_the_first_tick_of_each_period() -> None:
    cadence, drawn = Cadence(10.0, 1.0), []
    for tick in range(21):
        stamp = tick * 50_000_000
        if cadence.is_due(stamp) and cadence.may_draw(float(tick)):
            cadence.drawn(stamp, float(tick), 0.0)
            drawn.append(tick)
    assert drawn == list(range(0, 21, 2))
    cadence.restart()
    assert cadence.is_due(0)


def test_cadence_stays_under_its_load() -> None:
    cadence = Cadence(10.0, 0.25)
    cadence.drawn(0, 101.0, 1.0)
    assert not cadence.may_draw(103.9)
    assert cadence.may_draw(104.0)
    cadence.drawn(350_000_000, 104.1, 0.1)
    assert cadence.left_out == 2
    cadence.restart()
    cadence.drawn(0, 105.0, 0.0)
    assert cadence.left_out == 2
