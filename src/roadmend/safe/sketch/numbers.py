"""Which vehicle an outline is: by the number in it, by the colour of the others, by the legend."""

import math
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence

import cv2
import numpy as np

from roadmend.safe.sketch.outlines import Outline, Paint
from roadmend.safe.sketch.picture import Mask, Pixels, SketchPicture
from roadmend.safe.sketch.words import SketchWord, read_crops

Number = tuple[int, float]  # of a vehicle, and the confidence

_LABEL = re.compile(r"[^\w]*[Vv]?\s*#?([1-9IilT|!/]|N|Z)[^\w]*")  # alone in a vehicle
_WRITTEN = re.compile(r"\W*[Vv]\s*([1-9Il|])\W*")
_NAMED = re.compile(r"(?<![\w.])[Vv](?:ehicle)?\s*#?\s*([1-9])(?!\d)")
_BARE = re.compile(r"\W*([1-9])\W*")
_ONES = frozenset("IilT|!/")
_GLYPH_HEIGHT = 48  # [pixels] that the library reads best
_GLYPH_MARGIN = 0.35  # [of its size] of paper around a glyph
_GLYPH_SIZE = (0.22, 1.0)  # [of the vehicle's width] of the longer side of a glyph
_SURE = 0.6
_WRITTEN_VOTE = 3  # of a label V1 beside the lone glyphs, which weigh their confidence
_READ_OF_A_COLOUR = 5  # vehicles whose glyphs are looked at
_CLEAR = 2.5  # [times] that the vote for a number outweighs the next one
_TRUST_IN_PAINT = 0.8  # what is left of the confidence where only the colour says it
_CONVENTION = {Paint.RED: 1, Paint.BLUE: 2}  # NHTSA's: where no number can be read
_TRUST_IN_CONVENTION = 0.5
_SPECK = 6  # [pixels] smaller pieces are dirt
_DARK = 110  # [grey level]
_WHITE = 225  # [grey level]


def numbers_of(picture: SketchPicture, outlines: Sequence[Outline], words: Sequence[SketchWord]) -> list[Number | None]:
    """The number of each outline, where there is one to be had."""
    named = _named(words)
    own = [_worded(outline, words) for outline in outlines]
    votes: dict[Paint, dict[int, float]] = defaultdict(lambda: defaultdict(float))
    for outline, number in zip(outlines, own, strict=True):
        if number is not None:
            votes[outline.paint][number[0]] += _WRITTEN_VOTE
    unread = list(_worth_reading(outlines, own, votes))
    for index, number in zip(unread, _glyphs(picture, [outlines[index] for index in unread]), strict=True):
        if number is not None and (not named or number[0] in named):
            own[index] = number
            votes[outlines[index].paint][number[0]] += number[1]
    painted = _by_paint(votes, {outline.paint for outline in outlines}, named)
    return [
        painted.get(outline.paint) if _is_overruled(outline, number, painted) else number
        for outline, number in zip(outlines, own, strict=True)
    ]


def _worth_reading(
    outlines: Sequence[Outline], own: Sequence[Number | None], votes: Mapping[Paint, Mapping[int, float]]
) -> Iterator[int]:
    """Those whose glyph may tell something: of a colour that a label speaks for none, of another a few."""
    read: dict[Paint, int] = defaultdict(int)
    for index, (outline, number) in enumerate(zip(outlines, own, strict=True)):
        decides = outline.paint in {Paint.GREY, Paint.BLACK} or (
            outline.paint not in votes and read[outline.paint] < _READ_OF_A_COLOUR
        )
        if number is None and decides:
            read[outline.paint] += 1
            yield index


def _named(words: Sequence[SketchWord]) -> frozenset[int]:
    """The numbers that a legend or a label names."""
    return frozenset(int(match[1]) for word in words for match in _NAMED.finditer(word.text))


def _is_overruled(outline: Outline, number: Number | None, painted: Mapping[Paint, Number]) -> bool:
    """A colour is one vehicle's; a glyph that reads otherwise than its like was misread. Grey and black are anybody's."""
    if outline.paint in {Paint.GREY, Paint.BLACK}:
        return False
    majority = painted.get(outline.paint)
    return number is None or (majority is not None and majority[0] != number[0])


def _worded(outline: Outline, words: Sequence[SketchWord]) -> Number | None:
    """By a word that stands in the outline."""
    found: dict[int, float] = {}
    for word in words:
        text = word.text.strip()
        match = _WRITTEN.fullmatch(text) or _BARE.fullmatch(text)
        if match is not None and outline.holds(word.centre, 0.95):
            number = 1 if match[1] in _ONES else int(match[1])
            found[number] = max(found.get(number, 0.0), word.confidence)
    return next(iter(found.items())) if len(found) == 1 else None


def _by_paint(
    votes: Mapping[Paint, Mapping[int, float]], paints: set[Paint], named: frozenset[int]
) -> dict[Paint, Number]:
    """The number of each colour: heaviest vote first, and no number twice."""
    found: dict[Paint, Number] = {}
    heaviest = sorted(votes.items(), key=lambda item: -max(item[1].values()))
    for paint, counted in heaviest:
        (number, weight), *others = sorted(counted.items(), key=lambda vote: -vote[1])
        clear = not others or weight >= _CLEAR * others[0][1]
        taken = number in {known for known, _ in found.values()}
        if clear and (not taken or weight >= _WRITTEN_VOTE):
            found[paint] = number, _TRUST_IN_PAINT * min(1.0, 0.7 + 0.1 * weight)
    for paint, number in _CONVENTION.items():
        known = {other for other, _ in found.values()}
        if paint in paints and paint not in found and number not in known and (not named or number in named):
            found[paint] = number, _TRUST_IN_CONVENTION
    return found


def _glyphs(picture: SketchPicture, outlines: Sequence[Outline]) -> list[Number | None]:
    """By a lone glyph in each of some outlines, whichever way it is turned."""
    crops: list[Pixels] = []
    owners: list[int] = []
    for index, outline in enumerate(outlines):
        for crop in _turned_glyphs(picture, outline):
            crops.append(crop)
            owners.append(index)
    read: dict[int, dict[int, float]] = defaultdict(dict)
    for owner, (text, confidence) in zip(owners, read_crops(crops), strict=True):
        match = _LABEL.fullmatch(text)
        if match is None or confidence < _SURE:
            continue
        if match[1] in "NZ":  # a 2 that lies on its side, which the other turns will tell
            continue
        number = 1 if match[1] in _ONES else int(match[1])
        read[owner][number] = max(read[owner].get(number, 0.0), confidence)
    return [_decided(read[index]) for index in range(len(outlines))]


def _decided(found: Mapping[int, float]) -> Number | None:
    """A 1 looks like a 1 or a 7 in some turns, whatever else it is; a 6 is a 9 upside down."""
    others = {number: confidence for number, confidence in found.items() if number in {2, 3, 4, 5, 8}}
    if len(others) == 1:
        number, confidence = next(iter(others.items()))
        if confidence > 0.8 or 1 not in found:
            return number, confidence
    if 1 in found and not others:
        return 1, found[1]
    return None


def _turned_glyphs(picture: SketchPicture, outline: Outline) -> list[Pixels]:
    size = math.ceil(math.hypot(outline.length, outline.width)) + 4
    patch = np.ascontiguousarray(cv2.getRectSubPix(picture.colours, (size, size), outline.centre))
    inside = np.zeros((size, size), np.uint8)
    moved = outline.corners() - np.array(outline.centre) + (size - 1) / 2
    middle = (moved - moved.mean(axis=0)) * 0.86 + moved.mean(axis=0)
    cv2.fillPoly(inside, [middle.round().astype(np.int32)], 255)
    for mask in _contrasts(patch, outline.paint):
        glyph = _glyph_box(cv2.bitwise_and(mask, inside), outline)
        if glyph is not None:
            left, top, right, bottom = glyph
            paper = np.where(mask[..., None] > 0, 0, 255).astype(np.uint8).repeat(3, axis=2)
            centre = ((left + right) / 2, (top + bottom) / 2)
            reach = max(right - left, bottom - top) * (1 + 2 * _GLYPH_MARGIN)
            return [
                _turned(paper, centre, reach, angle)
                for angle in (0.0, *(-outline.axis + quarter for quarter in (0, 90, 180, 270)))
            ]
    return []


def _contrasts(patch: Pixels, paint: Paint) -> list[Mask]:
    """What may be a number in a patch: it is of another colour than the outline."""
    grey = np.asarray(cv2.cvtColor(patch, cv2.COLOR_RGB2GRAY))
    chroma = patch.max(axis=2) - patch.min(axis=2)
    dark = ((grey < _DARK) & (chroma < 70)).astype(np.uint8) * np.uint8(255)
    coloured = (chroma > 40).astype(np.uint8) * np.uint8(255)
    white = (grey > _WHITE).astype(np.uint8) * np.uint8(255)
    if paint is Paint.BLACK:
        return [coloured, dark]
    return [dark] if paint is Paint.GREY else [dark, white]


def _glyph_box(mask: Mask, outline: Outline) -> tuple[int, int, int, int] | None:
    """Around the largest piece that has the size of a letter, and the one beside it: "V1" are two."""
    count, _, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    low, high = (share * outline.width for share in _GLYPH_SIZE)
    pieces = []
    for label in range(1, count):
        left, top, width, height, area = (int(value) for value in stats[label])
        if low < max(width, height) < high and _SPECK < area < 0.8 * width * height + 8:
            pieces.append((area, (left, top, left + width, top + height)))
    if not pieces:
        return None
    _, best = max(pieces)
    size = max(best[2] - best[0], best[3] - best[1])
    for _, piece in pieces:
        other = max(piece[2] - piece[0], piece[3] - piece[1])
        apart = math.dist(
            ((best[0] + best[2]) / 2, (best[1] + best[3]) / 2), ((piece[0] + piece[2]) / 2, (piece[1] + piece[3]) / 2)
        )
        if piece is not best and 0.6 < other / size < 1.6 and apart < 1.1 * size:
            return min(best[0], piece[0]), min(best[1], piece[1]), max(best[2], piece[2]), max(best[3], piece[3])
    return best


def _turned(paper: Pixels, centre: tuple[float, float], reach: float, angle: float) -> Pixels:
    scale = _GLYPH_HEIGHT / reach
    turn = cv2.getRotationMatrix2D(centre, angle, scale)
    turn[:, 2] += _GLYPH_HEIGHT / 2 - np.array(centre)
    turned = cv2.warpAffine(
        paper, turn, (_GLYPH_HEIGHT, _GLYPH_HEIGHT), flags=cv2.INTER_CUBIC, borderValue=(255, 255, 255)
    )
    return np.ascontiguousarray(turned, dtype=np.uint8)
