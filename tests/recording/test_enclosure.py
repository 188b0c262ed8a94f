import pytest

from roadmend.core.errors import InputError
from roadmend.recording.enclosure import Attachment, metadata_from_file


@pytest.mark.parametrize(
    ("name", "media_type"),
    [
        ("scenario.yaml", "application/yaml"),
        ("versions.json", "application/json"),
        ("notes.txt", "text/plain"),
        ("model.safetensors", "application/octet-stream"),
    ],
)
def test_an_attachment_has_its_name_and_type(tmp_path, name, media_type):
    (tmp_path / name).write_bytes(b"\x00\xff")
    assert Attachment.from_file(tmp_path / name) == Attachment(name, media_type, b"\x00\xff")


@pytest.mark.parametrize(
    ("name", "said"), [("missing.yaml", r"missing\.yaml: no such file"), (".", r"cannot be read \(Is a directory\)")]
)
def test_an_attachment_that_cannot_be_read_is_named(tmp_path, name, said):
    with pytest.raises(InputError, match=rf"{said}; name a file that can be read"):
        Attachment.from_file(tmp_path / name)


def test_metadata_become_texts(tmp_path):
    path = tmp_path / "metadata.json"
    path.write_text('{"seed": 7, "method": "rss", "options": {"a": [1.5, null]}}')
    assert metadata_from_file(path) == {"seed": "7", "method": "rss", "options": '{"a": [1.5, null]}'}


@pytest.mark.parametrize(
    ("text", "what"), [("[1]", "holds no JSON object"), ("{", "line 1: broken JSON"), ("\xff", "cannot be read")]
)
def test_metadata_of_another_shape_are_refused(tmp_path, text, what):
    path = tmp_path / "metadata.json"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(InputError, match=what):
        metadata_from_file(path)


def test_missing_metadata_are_named(tmp_path):
    with pytest.raises(InputError, match=r"absent\.json: no such file"):
        metadata_from_file(tmp_path / "absent.json")
