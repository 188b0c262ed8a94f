"""A BERT encoder of a few weights, as files."""

import json

import numpy as np
import safetensors.numpy

WIDTH, INNER = 16, 24
SIGNS = [*"abcdefghijklmnopqrstuvwxyz0123456789.,:;'-/()"]
WORDS = ["[PAD]", "[UNK]", "[CLS]", "[SEP]", *SIGNS, *(f"##{sign}" for sign in SIGNS)]
WORDS += ["north", "south", "east", "west", "##bound", "car", "van", "hit", "the", "left", "right", "was", "on"]


def write_bert(folder, scope="", layers=1, positions=512, **changes):
    """Write the files of a small encoder with drawn weights, and return these.

    Args:
        folder: is made.
        scope: before the names of the weights.
        layers: that there are.
        positions: longest text.
        changes: of its configuration, which then does not fit.
    """
    folder.mkdir(exist_ok=True)
    generator = np.random.default_rng(1)

    def drawn(*sizes):
        return generator.normal(size=sizes, scale=0.2).astype(np.float32)

    tensors = {
        "embeddings.word_embeddings.weight": drawn(len(WORDS), WIDTH),
        "embeddings.position_embeddings.weight": drawn(positions, WIDTH),
        "embeddings.token_type_embeddings.weight": drawn(2, WIDTH),
        "embeddings.LayerNorm.weight": drawn(WIDTH),
        "embeddings.LayerNorm.bias": drawn(WIDTH),
    }
    maps = dict.fromkeys([f"attention.self.{name}" for name in ("query", "key", "value")], (WIDTH, WIDTH))
    maps |= {
        "attention.output.dense": (WIDTH, WIDTH),
        "intermediate.dense": (INNER, WIDTH),
        "output.dense": (WIDTH, INNER),
    }
    for layer in range(layers):
        own = f"encoder.layer.{layer}."
        for name, sizes in maps.items():
            tensors |= {f"{own}{name}.weight": drawn(*sizes), f"{own}{name}.bias": drawn(sizes[0])}
        for name in ("attention.output.LayerNorm", "output.LayerNorm"):
            tensors |= {
                f"{own}{name}.weight": drawn(WIDTH),
                f"{own}{name}.bias": drawn(WIDTH),
            }
    settings = {
        "hidden_size": WIDTH,
        "num_hidden_layers": layers,
        "num_attention_heads": 2,
        "intermediate_size": INNER,
        "max_position_embeddings": positions,
        "hidden_act": "gelu",
    }
    (folder / "config.json").write_text(json.dumps(settings | changes))
    (folder / "vocab.txt").write_text("\n".join(WORDS) + "\n")
    safetensors.numpy.save_file({scope + name: value for name, value in tensors.items()}, folder / "model.safetensors")
    return tensors
