"""Words on a sketch: read by a program that may be missing, may fail, and may read nonsense."""

import io
import stat

import pytest
from PIL import Image, ImageDraw, ImageFont

from roadmend.language.chat import Image as Sketch
from roadmend.safe.sketch_text import PROGRAM, is_sketch_read, posted_limit, read_sketch


def drawn(text):
    image = Image.new("RGB", (900, 120), "white")
    ImageDraw.Draw(image).text((20, 30), text, "black", ImageFont.load_default(48))
    data = io.BytesIO()
    image.save(data, "png")
    return Sketch(data.getvalue(), "image/png")


@pytest.fixture
def program(tmp_path, monkeypatch):
    """Puts a program of our own in the place of the real one."""

    def put(script):
        path = tmp_path / PROGRAM
        path.write_text(f"#!/bin/sh\n{script}\n")
        path.chmod(path.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")

    return put


def test_without_the_program(tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert not is_sketch_read()
    assert read_sketch(drawn("x")).note == "not read: the program tesseract is not installed"


def test_what_the_program_says_is_taken(program):
    program('head -c 4 | tail -c 3; echo " Speed limit 35 mph"')
    words = read_sketch(drawn("x"))
    assert words.text.startswith("PNG Speed limit 35 mph")  # it was handed a PNG
    assert words.note.startswith("its words were read")


def test_a_program_that_fails(program):
    program("exit 3")
    assert read_sketch(drawn("x")).note == "not read: tesseract failed on it (CalledProcessError)"


def test_a_sketch_that_breaks_off(program):
    program("cat")
    assert read_sketch(Sketch(drawn("x").data[:200], "image/png")).note.startswith("not read: tesseract failed on it")


@pytest.mark.skipif(not is_sketch_read(), reason="needs tesseract")
def test_the_real_program():
    assert posted_limit(read_sketch(drawn("Speed Limit 35 mph")).text) == 35


@pytest.mark.parametrize(
    ("text", "limit"),
    [
        ("Speed limit 35 mph", 35),
        ("SPEED LIMIT:\n55 MPH (89 kmph)", 55),
        ("Speed limit 45mph all legs, Speed limit 45 mph", 45),
        ("Speed limit 70 mph cars, 55 mph trucks", None),
        ("V1 at 35 mph", None),
        ("Speed limit 355 mph", None),
        ("Speed limit 89 kmph", None),
        ("", None),
    ],
)
def test_posted_limits(text, limit):
    assert posted_limit(text) == limit
