import pytest

from roadmend.recording.repeats import Repeats


def test_those_of_its_time_and_numbers_are_taken_once_each():
    repeats = Repeats.parse(str(Repeats(700, (4, 5, 5))))
    assert (len(repeats), str(repeats)) == (3, "700 4 5 5")
    take = repeats.taker()
    assert [take(700, 6), take(699, 4), take(700, 5), take(700, 5), take(700, 5), take(700, 4)] == [
        False,
        False,
        True,
        True,
        False,
        True,
    ]
    assert repeats.taker()(700, 4)  # taken anew


def test_numbers_are_compared_as_a_file_holds_them():
    assert Repeats(0, ((1 << 32) + 7,)).taker()(0, 7)


def test_a_bag_of_before_tells_only_how_many_come_first():
    repeats = Repeats.parse("2")
    take = repeats.taker()
    assert (len(repeats), [take(5, 90), take(8, 91), take(8, 92)]) == (2, [True, True, False])


@pytest.mark.parametrize("text", ["", "two", "5 x", "-1", str(1 << 60)])
def test_what_is_none_is_refused(text):
    with pytest.raises(ValueError, match=r"."):
        Repeats.parse(text)
