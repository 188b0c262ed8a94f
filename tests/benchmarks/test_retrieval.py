"""Recall of searches in a bank: of what the filter allows, each number once."""

import pytest

from harness.generated import generate
from harness.retrieval import draw_patterns, recalls, time_searches
from roadmend.sera.bank import Bank, build_bank
from roadmend.sera.filters import Filters

COUNT = 10


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """A bank, patterns, a filter for each, and what is found with it."""
    path = tmp_path_factory.mktemp("bank") / "a.bank"
    build_bank(path, generate(1000, 1))
    with Bank(path) as bank:
        patterns = draw_patterns(12, 2)
        filters = [Filters(weather=(("rainy", "foggy", "snowy")[place % 3],)) for place in range(len(patterns))]
        yield bank, patterns, filters, time_searches(bank, patterns, filters, COUNT)[0]


def test_what_the_search_finds_is_nearly_all(searched):
    assert min(recalls(*searched, COUNT)) > 0.8


def test_what_the_filter_forbids_does_not_count(searched):
    bank, patterns, filters, _ = searched
    found, _ = time_searches(bank, patterns, [None] * len(patterns), COUNT)
    allowed = [sum(bank.allowed(each)[numbers]) for each, numbers in zip(filters, found, strict=True)]
    assert sum(allowed) < len(patterns) * COUNT / 2
    for share, count in zip(recalls(bank, patterns, filters, found, COUNT), allowed, strict=True):
        assert share <= count / COUNT


def test_one_that_is_found_ten_times_counts_once(searched):
    bank, patterns, filters, found = searched
    shares = recalls(bank, patterns, filters, [numbers[:1] * COUNT for numbers in found], COUNT)
    assert set(shares) == {1 / COUNT}
