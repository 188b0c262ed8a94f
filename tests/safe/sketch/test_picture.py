"""Files that are no sketch, or want to be a large one."""

import io

import pytest
from PIL import Image

from roadmend.core.errors import InputError
from roadmend.language.chat import Image as Sketch

pytest.importorskip("cv2", reason="needs the extra sketch")

from roadmend.safe.sketch.picture import LONGER_SIDE, open_picture


def stored(image, kind="png"):
    data = io.BytesIO()
    image.save(data, kind)
    return Sketch(data.getvalue(), f"image/{kind}")


@pytest.mark.parametrize(
    "data", [b"", b"no picture", b"\x89PNG\r\n\x1a\n" + bytes(40), b"\xff\xd8\xff\xe0" + bytes(60)]
)
def test_what_is_no_picture(data):
    with pytest.raises(InputError, match="no picture that can be opened"):
        open_picture(Sketch(data, "image/png"))


def test_a_cut_file():
    sketch = stored(Image.effect_noise((200, 200), 80))
    with pytest.raises(InputError, match="no picture"):
        open_picture(Sketch(sketch.data[: len(sketch.data) // 2], sketch.media_type))


def test_a_strip_that_is_too_thin_to_be_made_smaller():
    with pytest.raises(InputError, match="smaller than 16 pixels where the longer side has 2000"):
        open_picture(stored(Image.new("RGB", (20, 131_092))))


def test_too_many_pixels():
    with pytest.raises(InputError, match="million pixels"):
        open_picture(stored(Image.new("1", (6000, 5000))))


def test_too_small():
    with pytest.raises(InputError, match="smaller than"):
        open_picture(stored(Image.new("RGB", (8, 300))))


def test_a_large_picture_is_made_smaller():
    picture = open_picture(stored(Image.new("RGB", (4000, 1000), "white")))
    assert (picture.width, picture.scale) == (LONGER_SIDE, 0.5)


def test_what_is_transparent_is_paper():
    picture = open_picture(stored(Image.new("RGBA", (40, 40), (0, 0, 0, 0))))
    assert picture.colours.min() == 255
    assert not picture.ink.any()


@pytest.mark.parametrize("mode", ["1", "L", "P", "CMYK"])
def test_every_mode_is_colours(mode):
    kind = "jpeg" if mode == "CMYK" else "png"
    assert open_picture(stored(Image.new("RGB", (40, 30), "red").convert(mode), kind)).colours.shape == (30, 40, 3)
