"""Classes of a user's own."""

import importlib
import sys
from pathlib import Path

import pytest

from tests.core.own_code import METHOD, POLICY


@pytest.fixture
def theirs(own):
    """A module with policies and one with repair methods, in the folder that the user is in."""
    names = own(POLICY), own(METHOD)
    sys.path.append(str(Path.cwd()))  # put back by ``own``
    importlib.invalidate_caches()
    return tuple(map(importlib.import_module, names))
