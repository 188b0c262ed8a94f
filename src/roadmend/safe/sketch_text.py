"""What is written on a sketch, read by the program tesseract where that is installed."""

import io
import os
import re
import shutil
import subprocess
from dataclasses import dataclass

import PIL.Image

from roadmend.language.chat import Image
from roadmend.safe.dsl import MAX_SPEED_LIMIT

PROGRAM = "tesseract"
_LONGER_SIDE = 2400  # [pixels] below that the small print of NHTSA's sketches is not made out
_PATIENCE = 60  # [s]
_MPH = re.compile(r"(?<!\d)(\d{2,3})\s*mph\b", re.IGNORECASE)
_SAYS_LIMIT = re.compile(r"speed|limit", re.IGNORECASE)


@dataclass(frozen=True, slots=True)
class SketchText:
    """The words of a sketch.

    Attributes:
        text: None where they were not read.
        note: whether they were read, and if not, why.
    """

    text: str | None
    note: str


def is_sketch_read() -> bool:
    """Whether the program is there."""
    return shutil.which(PROGRAM) is not None


def read_sketch(sketch: Image) -> SketchText:
    """Read the words of a sketch; never raises, for a report has more than its sketch."""
    if not is_sketch_read():
        return SketchText(None, f"not read: the program {PROGRAM} is not installed")
    # The libraries that the ROS wheels put in front are not those that the program was built with.
    environ = {name: value for name, value in os.environ.items() if name != "LD_LIBRARY_PATH"} | {
        "OMP_THREAD_LIMIT": "1"
    }
    try:
        done = subprocess.run(
            [PROGRAM, "-", "-", "--psm", "11"],
            input=_enlarged(sketch),
            capture_output=True,
            check=True,
            timeout=_PATIENCE,
            env=environ,
        )
    except (OSError, ValueError, SyntaxError, PIL.Image.DecompressionBombError, subprocess.SubprocessError) as error:
        return SketchText(None, f"not read: {PROGRAM} failed on it ({type(error).__name__})")
    note = f"its words were read by {PROGRAM}; lanes, ways and the north arrow were not"
    return SketchText(done.stdout.decode(errors="replace"), note)


def _enlarged(sketch: Image) -> bytes:
    with PIL.Image.open(io.BytesIO(sketch.data)) as image:
        grey = image.convert("L")
    scale = _LONGER_SIDE / max(grey.size)
    size = tuple(max(1, round(scale * side)) for side in grey.size)
    data = io.BytesIO()
    grey.resize((size[0], size[1]), PIL.Image.Resampling.LANCZOS).save(data, "png")
    return data.getvalue()


def posted_limit(text: str) -> int | None:
    """The speed limit [mph] that is written on a sketch; None where there is none, or more than one."""
    if not _SAYS_LIMIT.search(text):
        return None
    limits = {int(match[1]) for match in _MPH.finditer(text)}
    limit = limits.pop() if len(limits) == 1 else None
    return limit if limit is not None and 5 <= limit <= MAX_SPEED_LIMIT else None
