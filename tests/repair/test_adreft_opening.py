"""An intervention begins with full braking, for as long as it lasts at most."""

from roadmend.repair.adreft.opening import Opening

TICK = 0.05  # [s]


def actions(seconds, due, chosen=-0.4):
    opening = Opening(seconds)
    return [opening.action(number * TICK, chosen, is_due=each) for number, each in enumerate(due)]


def test_without_an_opening_the_choice_stands():
    assert actions(0.0, [True] * 4) == [-0.4] * 4


def test_full_braking_comes_first_and_the_choice_after_it():
    assert actions(0.2, [False] + [True] * 6) == [-0.4] + [-1.0] * 4 + [-0.4] * 2


def test_what_is_not_due_any_more_is_not_braked_and_the_next_one_opens_anew():
    assert actions(0.2, [True, True, False, True, True]) == [-1.0, -1.0, -0.4, -1.0, -1.0]


def test_an_episode_forgets_the_one_before():
    opening = Opening(0.1)
    assert [opening.action(time, 0.0, is_due=True) for time in (5.0, 5.2)] == [-1.0, 0.0]
    opening.reset()
    assert opening.action(0.0, 0.0, is_due=True) == -1.0
