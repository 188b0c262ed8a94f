import pytest

from roadmend.world.case_name import case_name, search_of


@pytest.mark.parametrize("technique", ["random", "avfuzzer", "Mine_2", "Outer.Tech", "2opt"])
def test_what_a_search_found_tells_which(technique):
    names = [case_name(("S1", "modular", "none", technique), 4000003, index) for index in (0, 245)]
    assert names[1] == f"S1-modular-none-{technique}-4000003-00245"
    assert {search_of(name) for name in names} == {f"S1-modular-none-{technique}-4000003"}


def test_a_search_that_evaluates_a_hundred_thousand_is_one_search():
    names = [case_name(("S1", "modular", "none", "random"), 3, index) for index in (99_999, 100_000, 999_999)]
    assert {search_of(name) for name in names} == {"S1-modular-none-random-3"}


@pytest.mark.parametrize("name", ["S3-7", "S3-12345", "town-3-12345", "cut-in-left", "a-3-7-12345"])
def test_what_was_drawn_or_named_by_somebody_has_no_kin(name):
    assert search_of(name) == name
