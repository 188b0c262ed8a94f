"""A vehicle of a sketch, cut out and laid level."""

import cv2
import numpy as np

from roadmend.safe.sketch.outlines import Outline
from roadmend.safe.sketch.picture import Pixels, SketchPicture


def level_crop(picture: SketchPicture, outline: Outline, width: int, height: int, margin: float = 0.0) -> Pixels:
    """The vehicle with its axis to the right, scaled to a size.

    Args:
        picture: that it is drawn in.
        outline: around it.
        width: of the result, along the axis [pixels].
        height: of the result [pixels].
        margin: [of the outline's length and width] that is added at each side.

    Returns:
        RGB, of shape (height, width, 3); white where the picture ends.
    """
    rear_left, front_left, rear_right = outline.corners()[[3, 0, 2]]
    along, aside = margin * (front_left - rear_left), margin * (rear_right - rear_left)
    source = np.stack([rear_left - along - aside, front_left + along - aside, rear_right - along + aside]).astype(
        np.float32
    )
    target = np.array([[0, 0], [width - 1, 0], [0, height - 1]], np.float32)
    enlarging = (width - 1) / max(1.0, outline.length * (1 + 2 * margin)) > 1
    crop = cv2.warpAffine(
        picture.colours,
        cv2.getAffineTransform(source, target),
        (width, height),
        flags=cv2.INTER_CUBIC if enlarging else cv2.INTER_AREA,
        borderMode=cv2.BORDER_CONSTANT,
        borderValue=(255, 255, 255),
    )
    return np.ascontiguousarray(crop, dtype=np.uint8)
