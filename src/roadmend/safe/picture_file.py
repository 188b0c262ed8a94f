"""The file of a picture, opened with Pillow: of the formats that a sketch may have, and without a word on standard error."""

import contextlib
import io
import logging
import struct
import warnings
import zlib
from collections.abc import Iterator

import PIL.Image

FORMATS = ("JPEG", "PNG", "GIF", "WEBP", "BMP", "TIFF")  # Pillow's parsers of others stay asleep
UNREADABLE = (  # what Pillow raises on a damaged image
    PIL.UnidentifiedImageError,
    OSError,
    SyntaxError,
    ValueError,
    LookupError,
    TypeError,
    ArithmeticError,
    RuntimeError,
    struct.error,
    zlib.error,
    MemoryError,
    PIL.Image.DecompressionBombError,
    Warning,
)
logging.getLogger("PIL").setLevel(
    logging.CRITICAL
)  # it tells of damages line by line; our caller has one line for them


@contextlib.contextmanager
def open_picture_file(data: bytes) -> Iterator[PIL.Image.Image]:
    """A picture, of which so far only the head has been read.

    A file that is damaged but can be read is read silently; whoever cannot live with the damage finds it in the pixels.

    Args:
        data: the file's content.

    Raises:
        UNREADABLE: here, or when pixels are read inside the block: it is no picture of FORMATS, or too large a one.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", PIL.Image.DecompressionBombWarning)
        with PIL.Image.open(io.BytesIO(data), formats=FORMATS) as image:
            yield image
