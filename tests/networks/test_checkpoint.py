"""Model files: what goes in comes out, the same content gives the same bytes, and nothing else is taken."""

import json
import struct

import numpy as np
import pytest
import safetensors.numpy
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import FORMAT, find_model, load_checkpoint, save_checkpoint

HEADER = {
    "kind": "adreft",
    "configuration": {"hidden": 64, "widths": (64, 32), "rate": 1e-4, 10: "ten", 9: "nine"},
    "data_digest": "ab" * 32,
    "metrics": {"f1": 0.1 + 0.2},
    "ancestry": [],
}


def some_tensors():
    rng = np.random.default_rng(3)
    return {
        "b.weight": rng.normal(size=(3, 5)).astype(np.float32),
        "a.bias": rng.normal(size=4),
        "steps": np.arange(3),
        "empty": np.zeros((0, 2), np.float32),
        "turned": rng.normal(size=(4, 2)).astype(np.float32).T,
    }


@pytest.fixture
def path(tmp_path):
    return tmp_path / "folder" / "model.safetensors"


def refusal(path, kind=None):
    with pytest.raises(InputError) as caught:
        load_checkpoint(path, kind)
    assert "\n" not in str(caught.value)
    assert caught.value.where == str(path)
    return caught.value.what


def rewrite(path, change):
    """Change the file's own header, the JSON in front of the tensors."""
    data = path.read_bytes()
    length = struct.unpack("<Q", data[:8])[0]
    header = json.loads(data[8 : 8 + length])
    change(header["__metadata__"])
    text = json.dumps(header).encode()
    text += b" " * (-len(text) % 8)
    path.write_bytes(struct.pack("<Q", len(text)) + text + data[8 + length :])


def test_what_goes_in_comes_out(path):
    tensors = some_tensors()
    digest = save_checkpoint(path, tensors, HEADER)
    found = load_checkpoint(path, "adreft")
    assert found.digest == digest
    assert found.header == json.loads(json.dumps({**HEADER, "format": FORMAT}))
    assert found.tensors.keys() == tensors.keys()
    for name, array in tensors.items():
        assert found.tensors[name].dtype == array.dtype
        np.testing.assert_array_equal(found.tensors[name], array)
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]


def test_the_same_content_gives_the_same_bytes(path, tmp_path):
    save_checkpoint(path, some_tensors(), HEADER)
    turned = dict(reversed(some_tensors().items()))
    for number in range(5):
        other = tmp_path / f"{number}.safetensors"
        save_checkpoint(other, turned, dict(reversed(HEADER.items())))
        assert other.read_bytes() == path.read_bytes()


def test_a_saved_model_can_be_saved_again(path, tmp_path):
    digest = save_checkpoint(path, some_tensors(), HEADER)
    found = load_checkpoint(path)
    assert save_checkpoint(tmp_path / "again.safetensors", found.tensors, found.header) == digest


def test_headers_must_be_complete_and_plain(path):
    with pytest.raises(ValueError, match="lacks metrics, ancestry"):
        save_checkpoint(path, {}, {"kind": "x", "configuration": {}, "data_digest": ""})
    with pytest.raises(ValueError, match="JSON"):
        save_checkpoint(path, {}, {**HEADER, "metrics": {"f1": float("nan")}})
    assert not path.exists()


def test_what_cannot_be_written_leaves_nothing(tmp_path):
    (tmp_path / "model.safetensors").mkdir()
    with pytest.raises(InputError, match="cannot be written"):
        save_checkpoint(tmp_path / "model.safetensors", some_tensors(), HEADER)
    assert [entry.name for entry in tmp_path.iterdir()] == ["model.safetensors"]


def test_a_missing_file_is_refused(path):
    assert "no such file" in refusal(path)


def test_another_kind_is_refused(path):
    save_checkpoint(path, some_tensors(), HEADER)
    assert refusal(path, "neural") == "is a model of the kind 'adreft'"


@settings(max_examples=60, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(share=st.floats(0.0, 1.0, exclude_max=True))
def test_a_cut_file_is_refused_wherever_it_is_cut(path, share):
    save_checkpoint(path, some_tensors(), HEADER)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    assert "cut or damaged" in refusal(path)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(place=st.floats(0.0, 1.0, exclude_max=True), bit=st.integers(0, 7))
def test_a_flipped_bit_never_passes_for_the_model(path, place, bit):
    header = {**HEADER, "metrics": {"f1": 0.5}}  # the last of seventeen digits may change and mean the same number
    save_checkpoint(path, some_tensors(), header)
    data = bytearray(path.read_bytes())
    data[int(place * len(data))] ^= 1 << bit
    path.write_bytes(data)
    refusal(path, "adreft")


@pytest.mark.parametrize("content", [b"", b"\x80\x04N.", b"{}", b"\xff" * 100, struct.pack("<Q", 2) + b"{}"])
def test_foreign_files_are_refused(path, content):
    path.parent.mkdir()
    path.write_bytes(content)
    assert "is no model file" in refusal(path)


@pytest.mark.parametrize("metadata", [None, {"format": "pt"}, {"roadmend": "[]"}, {"roadmend": "{"}, {"roadmend": "7"}])
def test_safetensors_of_others_are_refused(path, metadata):
    path.parent.mkdir()
    path.write_bytes(safetensors.numpy.save({"weight": np.zeros(3, np.float32)}, metadata))
    assert "is no model file" in refusal(path)


def test_another_format_is_refused_as_such(path):
    save_checkpoint(path, some_tensors(), HEADER)
    rewrite(path, lambda metadata: metadata.update(roadmend=metadata["roadmend"].replace(FORMAT, "roadmend-model/2")))
    assert refusal(path) == f"has the format 'roadmend-model/2', not '{FORMAT}'"


def test_an_edited_header_is_refused(path):
    save_checkpoint(path, some_tensors(), HEADER)
    rewrite(path, lambda _: None)  # the edit alone does no harm
    load_checkpoint(path)
    rewrite(path, lambda metadata: metadata.update(roadmend=metadata["roadmend"].replace("0.30000000000000004", "0.9")))
    assert refusal(path) == "was changed or damaged since it was saved"


def test_a_policy_that_does_not_ship_is_told_of_policies_alone():
    with pytest.raises(InputError, match=r"choose one of: deep_sets, ego_mlp, neural, or give a path$"):
        find_model("modular")
