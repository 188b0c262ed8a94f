"""The sketches of the worked examples: there, small, and what the examples say."""

import io

import numpy as np
import PIL.Image
import pytest

from roadmend.safe.example_sketch import draw_sketch
from roadmend.safe.knowledge_base import templates

EXAMPLES = [example for template in templates().values() for example in template.examples]


def pixels(data):
    with PIL.Image.open(io.BytesIO(data)) as image:
        return np.asarray(image.convert("RGB"), dtype=float)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.picture)
def test_each_is_kept_as_it_is_drawn(example):
    kept = example.sketch
    assert kept.media_type == "image/png"
    assert len(kept.data) < 30_000
    drawn = pixels(draw_sketch(example.answer))
    assert pixels(kept.data).shape == drawn.shape
    # Libraries differ in edges and letters, not in what is there.
    assert np.abs(pixels(kept.data) - drawn).mean() < 2.0


def test_they_differ():
    assert len({example.sketch.data for example in EXAMPLES}) == len(EXAMPLES)
