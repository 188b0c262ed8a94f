"""Whatever bytes a reader is given, it gives a value or the documented error, in one line."""

import random

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fuzz_mutation import SIZE_MAX, mutated
from fuzz_readers import DOCUMENTED, READERS, place_of, seeds_of
from roadmend.core.errors import InputError

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
        content = mutated(files, random.Random(number))
        check(content)
        if READERS[name].renewed is not None:
            check(READERS[name].renewed(content))

    for seed in files:
        check(seed)
    any_bytes()
    changed()


@pytest.mark.parametrize("name", READERS)
def test_a_seed_is_read_and_a_change_of_it_is_not_cut(name, tmp_path):
    seed = seeds_of(name)[0]
    assert len(seed) < SIZE_MAX
    path = place_of(name, tmp_path)
    path.write_bytes(seed)
    READERS[name].read(path)


def test_changed_weights_of_a_model_get_past_its_checksum(tmp_path):
    (seed, *_), renewed = seeds_of("model"), READERS["model"].renewed
    path = place_of("model", tmp_path)
    changed = seed[:-4] + b"\0\0\x80\x3f"  # the last weight: 1
    path.write_bytes(changed)
    with pytest.raises(InputError, match="changed or damaged since"):
        READERS["model"].read(path)
    for content in (renewed(changed), renewed(seed), renewed(seed + b"more"), renewed(b"\0" * 8 + seed[8:])):
        path.write_bytes(content)
        READERS["model"].read(path)
    assert renewed(seed) == seed != renewed(changed)
    path.write_bytes(renewed(seed[:-4] + b"\xff" * 4))  # not a number
    with pytest.raises(InputError, match="not finite"):
        READERS["model"].read(path)
    assert renewed(b"[]") == b"[]"
