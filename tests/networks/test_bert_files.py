"""The folder of a BERT encoder becomes a text encoder that reads as the BERT does."""

import json

import numpy as np
import pytest
import safetensors.numpy
import torch

from roadmend.core.errors import InputError
from roadmend.networks.bert_files import fewer_pieces, read_bert
from roadmend.networks.text_encoder import TextReader
from tests.networks.small_bert import INNER, WIDTH, WORDS, write_bert


def read_by_torch(tensors, pieces):
    """What PyTorch's own layer makes of it."""
    layer = torch.nn.TransformerEncoderLayer(WIDTH, 2, INNER, 0.0, "gelu", batch_first=True).eval()
    own = "encoder.layer.0."

    def of(name):
        return {part: torch.from_numpy(tensors[f"{own}{name}.{part}"]) for part in ("weight", "bias")}

    query, key, value = (of(f"attention.self.{name}") for name in ("query", "key", "value"))
    with torch.no_grad():
        for part in ("weight", "bias"):
            getattr(layer.self_attn, f"in_proj_{part}").copy_(torch.cat([query[part], key[part], value[part]]))
    layer.self_attn.out_proj.load_state_dict(of("attention.output.dense"))
    layer.linear1.load_state_dict(of("intermediate.dense"))
    layer.linear2.load_state_dict(of("output.dense"))
    layer.norm1.load_state_dict(of("attention.output.LayerNorm"))
    layer.norm2.load_state_dict(of("output.LayerNorm"))
    of_place = {name: torch.from_numpy(tensors[f"embeddings.{name}"]) for name in tensors_of_embeddings(tensors)}
    states = of_place["word_embeddings.weight"][pieces] + of_place["position_embeddings.weight"][: len(pieces)]
    states = states + of_place["token_type_embeddings.weight"][0]
    norm = (of_place["LayerNorm.weight"], of_place["LayerNorm.bias"])
    states = torch.nn.functional.layer_norm(states, (WIDTH,), *norm)
    with torch.no_grad():
        return layer(states[None])[0].numpy()


def tensors_of_embeddings(tensors):
    return [name.removeprefix("embeddings.") for name in tensors if name.startswith("embeddings.")]


@pytest.mark.parametrize("scope", ["", "bert."])
def test_it_reads_as_the_bert_does(tmp_path, scope):
    tensors = write_bert(tmp_path, scope)
    shape, found, vocabulary = read_bert(tmp_path, marks=3)
    assert vocabulary == WORDS
    assert (shape.pieces, shape.positions, shape.hidden, shape.layers, shape.marks) == (len(WORDS), 512, WIDTH, 1, 3)
    pieces = np.array([2, 90, 41, 5, 6, 3])
    reader = TextReader(shape, found | {"marks.weight": np.zeros((3, WIDTH), np.float32)}, prefix="")
    read = reader.read(pieces, np.zeros(6, np.int64))
    assert np.abs(read - read_by_torch(tensors, pieces)).max() < 1e-4


def test_the_file_of_a_tokenizer_serves_as_well(tmp_path):
    write_bert(tmp_path)
    (tmp_path / "vocab.txt").unlink()
    vocabulary = {word: place for place, word in enumerate(WORDS)}
    (tmp_path / "tokenizer.json").write_text(json.dumps({"model": {"vocab": vocabulary}}))
    assert read_bert(tmp_path, marks=3)[2] == WORDS


def test_it_can_forget_pieces(tmp_path):
    write_bert(tmp_path)
    _, tensors, vocabulary = read_bert(tmp_path, marks=3)
    fewer, left = fewer_pieces(tensors, vocabulary, [1, 2, 3, WORDS.index("the")])
    assert left == ["[UNK]", "[CLS]", "[SEP]", "the"]
    assert (fewer["pieces.weight"] == tensors["pieces.weight"][[1, 2, 3, WORDS.index("the")]]).all()


def only_tokenizer(folder, content):
    (folder / "vocab.txt").unlink()
    (folder / "tokenizer.json").write_text(content)


def without_types(folder):
    tensors = safetensors.numpy.load_file(folder / "model.safetensors")
    tensors["embeddings.token_type_embeddings.weight"] = np.zeros((0, WIDTH), np.float32)
    safetensors.numpy.save_file(tensors, folder / "model.safetensors")


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_what_ends_a_line_to_unicode_may_be_a_piece(tmp_path, end):
    write_bert(tmp_path)
    words = [*WORDS[:-2], "\u2028", "a\x85b"]
    (tmp_path / "vocab.txt").write_bytes("".join(word + end for word in words).encode())
    assert read_bert(tmp_path, marks=3)[2] == words


@pytest.mark.parametrize(
    ("damage", "told"),
    [
        (lambda folder: (folder / "config.json").write_text("{}"), "is not that of a BERT encoder"),
        (lambda folder: (folder / "config.json").unlink(), "config.json"),
        (lambda folder: only_tokenizer(folder, '{"model": {}}'), "holds no vocabulary"),
        (lambda folder: only_tokenizer(folder, "[]"), "holds no fields"),
        (lambda folder: (folder / "model.safetensors").write_bytes(b"cut"), "its weights are not those"),
        (lambda folder: safetensors.numpy.save_file({}, folder / "model.safetensors"), "no word embeddings"),
        (lambda folder: write_bert(folder, hidden_act="relu"), "rectify by 'relu'"),
        (lambda folder: write_bert(folder, num_hidden_layers=2), "its weights are not those"),
        (lambda folder: write_bert(folder, num_hidden_layers=30), r"field layers: .*24 \(got 30\)"),
        (lambda folder: write_bert(folder, num_hidden_layers=0), r"field layers: .*1 \(got 0\)"),
        (lambda folder: write_bert(folder, hidden_size=5000), "field hidden: .*4096"),
        (lambda folder: write_bert(folder, intermediate_size=5000), "field feed_forward: .*4096"),
        (lambda folder: write_bert(folder, num_attention_heads=5), "heads: 5 cannot share a hidden width of 16 evenly"),
        (lambda folder: (folder / "vocab.txt").write_text(""), "field pieces: "),
        (lambda folder: (folder / "vocab.txt").write_text("a\n" * 200_001), "field pieces: .*200000"),
        (lambda folder: only_tokenizer(folder, '{"model": {"vocab": {"a": [0]}}}'), "holds no vocabulary"),
        (lambda folder: only_tokenizer(folder, '{"model": {"vocab": {"a": false}}}'), "holds no vocabulary"),
        (without_types, "there are no types of tokens"),
    ],
)
def test_what_is_no_bert_is_refused_in_a_line(tmp_path, damage, told):
    write_bert(tmp_path)
    damage(tmp_path)
    with pytest.raises(InputError, match=told) as caught:
        read_bert(tmp_path, marks=3)
    assert "\n" not in str(caught.value)
