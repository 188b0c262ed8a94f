"""The sketch as a source of claims, with its libraries, without them, and with files that are no sketch."""

import builtins
import sys

import pytest

from roadmend.language.chat import Image
from roadmend.safe.claims import CastMember
from roadmend.safe.sketch_claims import claims_of_sketch, is_sketch_read

CAST = (CastMember(1, ("v1",), None),)


def test_without_the_libraries_it_says_how_to_mend(monkeypatch):
    real = builtins.__import__

    def without(name, *args, **kwargs):
        if name.partition(".")[0] == "cv2":
            raise ModuleNotFoundError("No module named 'cv2'", name="cv2")
        return real(name, *args, **kwargs)

    for name in [name for name in sys.modules if name.startswith("roadmend.safe.sketch.") or name == "cv2"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setattr(builtins, "__import__", without)
    assert not is_sketch_read()
    found = claims_of_sketch(Image(b"", "image/png"), CAST)
    assert found.claims == ()
    assert found.note.startswith(
        "not read: cv2: needed here and not installed; install it with: pip install 'roadmend[sketch]'"
    )


def test_what_is_no_picture_is_a_note():
    pytest.importorskip("cv2", reason="needs the extra sketch")
    found = claims_of_sketch(Image(b"nothing", "image/png"), CAST)
    assert found.claims == ()
    assert found.note.startswith("not read: the sketch: is no picture that can be opened")


def test_a_sketch_is_read():
    pytest.importorskip("cv2", reason="needs the extra sketch")
    from .sketch.drawings import Drawing

    found = claims_of_sketch(Drawing().text(50, 50, "Speed limit 45 mph", 40).sketch(), CAST)
    assert [(claim.path, claim.value) for claim in found.claims] == [("vehicles[0].speed_limit_mph", 45)]
    assert found.note.startswith("read: 1 words, 1 posted limit")
