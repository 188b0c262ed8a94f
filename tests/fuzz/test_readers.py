"""Whatever bytes a reader is given, it gives a value or the documented error, in one line."""

import random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzz_mutation import mutated
from fuzz_readers import DOCUMENTED, READERS, place_of, seeds_of

EXAMPLES = 25  # each; fuzz/run.py goes through thousands
QUIET = settings(max_examples=EXAMPLES, deadline=None, suppress_health_check=[*HealthCheck], derandomize=True)


@pytest.fixture(scope="module")
def seeds():
    return {}


@pytest.mark.parametrize("name", READERS)
def test_any_bytes_are_read_or_refused(name, tmp_path, seeds):
    files = seeds.setdefault(name, seeds_of(name))
    path = place_of(name, tmp_path)

    def check(content):
        path.unlink(missing_ok=True)
        path.write_bytes(content)
        try:
            READERS[name].read(path)
        except DOCUMENTED as error:
            assert "\n" not in str(error)  # noqa: PT017 - it need not be raised

    @QUIET
    @given(st.binary(max_size=2000))
    def any_bytes(content):
        check(content)

    @QUIET
    @given(st.integers(0, 2**32))
    def changed(number):
        check(mutated(files, random.Random(number)))

    for seed in files:
        check(seed)
    any_bytes()
    changed()
