"""The sketch as a source of claims; without the libraries that read it, a note that says so."""

from collections.abc import Sequence
from dataclasses import dataclass

from roadmend.core.errors import InputError
from roadmend.core.extras import extra_missing
from roadmend.language.chat import Image
from roadmend.safe.claims import Cast, Claim


@dataclass(frozen=True, slots=True)
class SketchClaims:
    """What a sketch adds.

    Attributes:
        claims: none where it was not read.
        note: what was read, or why nothing was and how that is mended.
    """

    claims: Sequence[Claim]
    note: str


def is_sketch_read() -> bool:
    """Whether the libraries are there that read a sketch."""
    try:
        import roadmend.safe.sketch.claims  # noqa: F401, PLC0415
    except ModuleNotFoundError as error:
        extra_missing(error)
        return False
    return True


def claims_of_sketch(sketch: Image, cast: Cast) -> SketchClaims:
    """The claims of a sketch about the vehicles of a report; never raises, for a report has more than its sketch."""
    try:
        from roadmend.safe.sketch.claims import claims_of  # noqa: PLC0415
        from roadmend.safe.sketch.reading import read_sketch  # noqa: PLC0415
    except ModuleNotFoundError as error:
        return SketchClaims((), f"not read: {extra_missing(error)}")
    try:
        reading = read_sketch(sketch)
    except InputError as error:
        return SketchClaims((), f"not read: {error}")
    return SketchClaims(claims_of(reading, cast), reading.account())
