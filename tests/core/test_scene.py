"""The table of participants: put together from columns, read by column or by record."""

import numpy as np
import pytest

from roadmend.core.scene import COLUMNS, OBJECT, EgoState, ObjectList

GIVEN = {name: np.arange(3) + place for place, name in enumerate(COLUMNS)}


def test_every_column_comes_back_as_it_was_given():
    objects = ObjectList.of(**GIVEN)
    for name in COLUMNS:
        column = getattr(objects, name)
        assert column.dtype == OBJECT[name]
        assert column.tolist() == GIVEN[name].tolist()
        assert objects.table[1][name] == GIVEN[name][1]


def test_a_single_number_holds_for_all():
    assert ObjectList.of(**{**GIVEN, "width": 1.8}).width.tolist() == [1.8, 1.8, 1.8]


@pytest.mark.parametrize("name", COLUMNS)
@pytest.mark.parametrize("length", [1, 2, 4])
def test_columns_of_another_length_are_refused(name, length):
    with pytest.raises(ValueError, match="differ in length"):
        ObjectList.of(**{**GIVEN, name: np.ones(length)})


def test_a_column_that_is_missing_or_unknown_is_refused():
    with pytest.raises(TypeError, match="the columns are"):
        ObjectList.of(**GIVEN, colour=0)
    with pytest.raises(TypeError, match="the columns are"):
        ObjectList.of(id=[1])


def test_select_and_with_columns_leave_the_list_as_it_is():
    objects = ObjectList.of(**GIVEN)
    assert objects.select(np.array([True, False, True])).id.tolist() == [0, 2]
    assert objects.with_columns(x=5.0).x.tolist() == [5.0, 5.0, 5.0]
    assert objects.x.tolist() == GIVEN["x"].tolist()
    assert len(ObjectList.empty()) == 0


def test_the_ego_by_heading_and_by_quaternion_is_the_same():
    ego = EgoState.from_yaw(1.0, 2.0, 0.7, 3.0, 0.1, 4.5, 1.8)
    assert EgoState.from_quaternion(*ego[:8]) == ego
