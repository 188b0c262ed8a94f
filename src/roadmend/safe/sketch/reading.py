"""Everything that is read from a sketch."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache

from roadmend.language.chat import Image
from roadmend.safe.sketch.arrows import DrawnArrow, find_arrows
from roadmend.safe.sketch.fronts import triangle_front
from roadmend.safe.sketch.limits import SketchLimit, posted_limits
from roadmend.safe.sketch.north import NorthMark, find_north
from roadmend.safe.sketch.numbers import numbers_of
from roadmend.safe.sketch.outlines import find_outlines
from roadmend.safe.sketch.picture import SketchPicture, open_picture
from roadmend.safe.sketch.poses import Approach, VehiclePose, find_approaches
from roadmend.safe.sketch.words import SketchWord, read_words


@dataclass(frozen=True, slots=True)
class SketchReading:
    """What a sketch shows; places are in pixels of ``picture``.

    Attributes:
        picture: that it was read from.
        words: with their places.
        limits: speed limits that are posted.
        north: None where it is not marked.
        arrows: drawn in black.
        poses: of the vehicles, each as often as it is drawn.
        approaches: where each vehicle comes from, by its number.
    """

    picture: SketchPicture = field(repr=False)
    words: Sequence[SketchWord]
    limits: Sequence[SketchLimit]
    north: NorthMark | None
    arrows: Sequence[DrawnArrow]
    poses: Sequence[VehiclePose]
    approaches: Mapping[int, Approach]

    def account(self) -> str:
        """What was read, in a sentence's length; what was not, too."""
        numbers = sorted({pose.number for pose in self.poses if pose.number is not None})
        vehicles = f"vehicles {', '.join(map(str, numbers))}" if numbers else "no vehicle's number"
        limits = f"{len(self.limits)} posted limits" if len(self.limits) != 1 else "1 posted limit"
        north = "north" if self.north is not None else "no north"
        return f"read: {len(self.words)} words, {limits}, {vehicles}, {north}; lanes were not"


@lru_cache(maxsize=4)  # an extraction and then its page read the same sketch
def read_sketch(sketch: Image) -> SketchReading:
    """Read a sketch; the same file gives the same reading.

    Raises:
        InputError: it is no picture, or has too few or too many pixels.
    """
    picture = open_picture(sketch)
    words = read_words(picture)
    arrows = find_arrows(picture)
    outlines = find_outlines(picture, words)
    poses = [
        VehiclePose(
            outline, number[0] if number else None, number[1] if number else 0.0, triangle_front(picture, outline)
        )
        for outline, number in zip(outlines, numbers_of(picture, outlines, words), strict=True)
    ]
    return SketchReading(
        picture,
        words,
        posted_limits(words),
        find_north(picture, words, arrows),
        arrows,
        tuple(poses),
        find_approaches(poses, arrows),
    )
