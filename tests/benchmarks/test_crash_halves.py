"""The committed split of the shared reports is the one that its seed gives."""

import pytest
import yaml

from harness.crash_halves import SEEN, load_halves, split
from roadmend.core.errors import InputError


def test_the_file_holds_the_split_of_its_seed():
    halves = load_halves()
    names = halves["seen"] | halves["unseen"]
    assert {half: frozenset(own) for half, own in split([*names]).items()} == halves
    assert len(halves["seen"]) == SEEN


@pytest.mark.parametrize("content", [{"seen": ["a"]}, {"seen": ["a"], "unseen": ["a"]}])
def test_another_split_is_refused(tmp_path, content):
    (tmp_path / "halves.yaml").write_text(yaml.safe_dump(content), encoding="utf-8")
    with pytest.raises(InputError):
        load_halves(tmp_path / "halves.yaml")
