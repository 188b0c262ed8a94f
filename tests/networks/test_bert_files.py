"""The folder of a BERT encoder becomes a text encoder that reads as the BERT does."""

import json

import numpy as np
import pytest
import safetensors.numpy
import torch

from roadmend.core.errors import InputError
from roadmend.networks.bert_files import fewer_pieces, read_bert
from roadmend.networks.text_encoder import TextReader

WORDS = ["[PAD]", "[UNK]", "[CLS]", "[SEP]", "car", "##s", "hit", "the"]
WIDTH, INNER = 12, 20


def bert(folder, scope="", **changes):
    """Write the files of a small BERT with drawn weights, and return these."""
    generator = np.random.default_rng(4)

    def drawn(*sizes):
        return generator.normal(size=sizes, scale=0.3).astype(np.float32)

    tensors = {
        "embeddings.word_embeddings.weight": drawn(len(WORDS), WIDTH),
        "embeddings.position_embeddings.weight": drawn(16, WIDTH),
        "embeddings.token_type_embeddings.weight": drawn(2, WIDTH),
        "embeddings.LayerNorm.weight": drawn(WIDTH),
        "embeddings.LayerNorm.bias": drawn(WIDTH),
    }
    own = "encoder.layer.0."
    sizes = {
        **dict.fromkeys(("attention.self.query", "attention.self.key", "attention.self.value"), (WIDTH, WIDTH)),
        "attention.output.dense": (WIDTH, WIDTH),
        "intermediate.dense": (INNER, WIDTH),
        "output.dense": (WIDTH, INNER),
    }
    for name, (rows, columns) in sizes.items():
        tensors |= {f"{own}{name}.weight": drawn(rows, columns), f"{own}{name}.bias": drawn(rows)}
    for name in ("attention.output.LayerNorm", "output.LayerNorm"):
        tensors |= {f"{own}{name}.weight": drawn(WIDTH), f"{own}{name}.bias": drawn(WIDTH)}
    settings = {
        "model_type": "bert",
        "hidden_size": WIDTH,
        "num_hidden_layers": 1,
        "num_attention_heads": 2,
        "intermediate_size": INNER,
        "max_position_embeddings": 16,
        "hidden_act": "gelu",
    }
    (folder / "config.json").write_text(json.dumps(settings | changes))
    (folder / "tokenizer.json").write_text(
        json.dumps({"model": {"vocab": {word: at for at, word in enumerate(WORDS)}}})
    )
    safetensors.numpy.save_file({scope + name: value for name, value in tensors.items()}, folder / "model.safetensors")
    return tensors


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
    tensors = bert(tmp_path, scope)
    shape, found, vocabulary = read_bert(tmp_path, marks=3)
    assert vocabulary == WORDS
    assert (shape.pieces, shape.positions, shape.hidden, shape.layers, shape.marks) == (8, 16, WIDTH, 1, 3)
    pieces = np.array([2, 7, 4, 5, 6, 3])
    reader = TextReader(shape, found | {"marks.weight": np.zeros((3, WIDTH), np.float32)}, prefix="")
    read = reader.read(pieces, np.zeros(6, np.int64))
    assert np.abs(read - read_by_torch(tensors, pieces)).max() < 1e-4


def test_a_list_of_words_serves_as_well(tmp_path):
    bert(tmp_path)
    (tmp_path / "tokenizer.json").unlink()
    (tmp_path / "vocab.txt").write_text("\n".join(WORDS) + "\n")
    assert read_bert(tmp_path, marks=3)[2] == WORDS


def test_it_can_forget_pieces(tmp_path):
    bert(tmp_path)
    _, tensors, vocabulary = read_bert(tmp_path, marks=3)
    fewer, left = fewer_pieces(tensors, vocabulary, [1, 2, 3, 7])
    assert left == ["[UNK]", "[CLS]", "[SEP]", "the"]
    assert (fewer["pieces.weight"] == tensors["pieces.weight"][[1, 2, 3, 7]]).all()


@pytest.mark.parametrize(
    ("damage", "told"),
    [
        (lambda folder: (folder / "config.json").write_text("{}"), "is not that of a BERT encoder"),
        (lambda folder: (folder / "config.json").unlink(), "config.json"),
        (lambda folder: (folder / "tokenizer.json").write_text('{"model": {}}'), "holds no vocabulary"),
        (lambda folder: (folder / "tokenizer.json").write_text("[]"), "holds no fields"),
        (lambda folder: (folder / "model.safetensors").write_bytes(b"cut"), "its weights are not those"),
        (lambda folder: safetensors.numpy.save_file({}, folder / "model.safetensors"), "no word embeddings"),
        (lambda folder: bert(folder, hidden_act="relu"), "rectify by 'relu'"),
        (lambda folder: bert(folder, num_hidden_layers=2), "its weights are not those"),
    ],
)
def test_what_is_no_bert_is_refused_in_a_line(tmp_path, damage, told):
    bert(tmp_path)
    damage(tmp_path)
    with pytest.raises(InputError, match=told) as caught:
        read_bert(tmp_path, marks=3)
    assert "\n" not in str(caught.value)
