"""Tests for opening the file of a picture."""

import contextlib
import io
import warnings

import PIL.Image
import pytest

from roadmend.safe.picture_file import FORMATS, UNREADABLE, open_picture_file


def content(form, size=(20, 20)):
    data = io.BytesIO()
    PIL.Image.new("RGB", size, (9, 99, 199)).save(data, form)
    return data.getvalue()


@pytest.mark.parametrize("form", FORMATS)
def test_each_format_is_opened_and_its_pixels_can_be_read(form):
    with open_picture_file(content(form)) as image:
        assert image.format == form
        assert image.convert("RGB").size == (20, 20)


@pytest.mark.parametrize("form", ["EPS", "PPM"])
def test_no_other_parser_is_woken(form):
    with pytest.raises(UNREADABLE), open_picture_file(content(form)):
        pass


def test_damage_that_can_be_read_over_is_not_told_of_line_by_line(recwarn):
    whole = content("TIFF")
    said = 0
    for end in range(20, len(whole), 7):
        with contextlib.suppress(*UNREADABLE), open_picture_file(whole[:end]) as image:
            image.convert("RGB")
        with warnings.catch_warnings(record=True) as caught, contextlib.suppress(*UNREADABLE):
            warnings.simplefilter("always")
            PIL.Image.open(io.BytesIO(whole[:end])).convert("RGB")
        said += len(caught)
    assert said > 0  # Pillow by itself does
    assert [*recwarn] == []
