"""The picture of a sketch as arrays, within bounds whatever the file holds."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import cv2
import numpy as np
import PIL.Image
from numpy.typing import NDArray

from roadmend.core.bounds import SKETCH
from roadmend.core.errors import InputError
from roadmend.language.chat import Image
from roadmend.safe.picture_file import UNREADABLE, open_picture_file

Pixels = NDArray[np.uint8]
Mask = NDArray[np.uint8]  # 255 inside, 0 outside

LONGER_SIDE = 2000  # [pixels] what is larger is made smaller: NHTSA's are 620 to 1530 wide
SHORTEST = 16  # [pixels] what is smaller is no drawing
_INK = 165  # [grey level] darker is drawn, lighter is paper: thin grey lines reach 200, but so do the blurs of JPEG
_THIN_INK = 215
_COLOURED = 30  # [levels] between the strongest and the weakest of red, green and blue, from here on it is a colour


@dataclass(frozen=True)
class SketchPicture:
    """A sketch, drawn on white.

    Attributes:
        colours: RGB, of shape (height, width, 3).
        scale: pixels here for one pixel of the file.
    """

    colours: Pixels
    scale: float = 1.0

    @property
    def height(self) -> int:
        """In pixels."""
        return int(self.colours.shape[0])

    @property
    def width(self) -> int:
        """In pixels."""
        return int(self.colours.shape[1])

    @property
    def diagonal(self) -> float:
        """In pixels."""
        return float(np.hypot(self.width, self.height))

    @cached_property
    def grey(self) -> Pixels:
        """Brightness, of shape (height, width)."""
        return _pixels(cv2.cvtColor(self.colours, cv2.COLOR_RGB2GRAY))

    @cached_property
    def hsv(self) -> Pixels:
        """Hue [2 deg], saturation and value, of shape (height, width, 3)."""
        return _pixels(cv2.cvtColor(self.colours, cv2.COLOR_RGB2HSV))

    @cached_property
    def ink(self) -> Mask:
        """What is drawn, in whatever colour, but for the faintest."""
        return _mask(self.grey < _INK) | self.coloured

    @cached_property
    def thin_ink(self) -> Mask:
        """What is drawn, the faintest lines among it."""
        return _mask(self.grey < _THIN_INK) | self.coloured

    @cached_property
    def coloured(self) -> Mask:
        """What has a colour, and is neither black, grey nor white."""
        return _mask(self.colours.max(axis=2) - self.colours.min(axis=2) > _COLOURED)


def open_picture(sketch: Image) -> SketchPicture:
    """The picture in a file; transparent parts are paper.

    Raises:
        InputError: it is no picture, or has too few or too many pixels.
    """
    mend = "give a JPEG or PNG file"
    try:
        with open_picture_file(sketch.data) as image:
            if image.width * image.height > SKETCH.values:
                raise InputError("the sketch", f"has more than {SKETCH.values // 1_000_000} million pixels", mend)
            scale = min(1.0, LONGER_SIDE / max(image.size))
            if scale * min(image.size) < SHORTEST:
                long = f" where the longer side has {LONGER_SIDE}" if scale < 1.0 else ""
                raise InputError("the sketch", f"is smaller than {SHORTEST} pixels{long}", mend)
            flat = PIL.Image.new("RGBA", image.size, "white")
            flat.alpha_composite(image.convert("RGBA"))
    except UNREADABLE as error:
        raise InputError("the sketch", f"is no picture that can be opened ({type(error).__name__})", mend) from error
    colours = _pixels(np.asarray(flat.convert("RGB")))
    if scale < 1.0:
        colours = _pixels(cv2.resize(colours, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA))
    return SketchPicture(colours, scale)


def _pixels(values: Any) -> Pixels:
    return np.ascontiguousarray(values, dtype=np.uint8)


def _mask(values: NDArray[np.bool_]) -> Mask:
    return values.astype(np.uint8) * np.uint8(255)
