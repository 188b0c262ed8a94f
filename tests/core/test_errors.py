import pickle

import pytest

from roadmend.core.errors import ForeignError, InputError


def test_an_input_error_is_one_line_of_what_where_and_how_to_mend():
    error = InputError("a.yaml", "is no scenario", "write one with 'roadmend sample'")
    assert str(error) == "a.yaml: is no scenario; write one with 'roadmend sample'"


def test_an_input_error_comes_out_of_a_worker_process_as_it_went_in():
    error = InputError("a.yaml", "is no scenario", "write one")
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), again.where, again.what, again.mend) == (InputError, "a.yaml", "is no scenario", "write one")
    assert str(again) == str(error)


@pytest.mark.parametrize("kind", [InputError, ForeignError])
def test_an_error_that_is_made_anew_from_itself_is_the_same(kind):
    error = kind("a.yaml", "is no scenario", "write one")
    again = kind(error)
    assert (type(again), again.where, again.what, again.mend) == (kind, "a.yaml", "is no scenario", "write one")
    assert str(again) == str(error)
