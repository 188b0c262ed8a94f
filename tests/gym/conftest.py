"""SUMO is free when a test begins, whatever became of the one before."""

import contextlib

import libsumo
import pytest


@pytest.fixture(autouse=True)
def _free():
    yield
    if libsumo.isLoaded():
        with contextlib.suppress(libsumo.TraCIException, libsumo.FatalTraCIError):
            libsumo.close()
