"""A BERT encoder of a few weights, as files, and told crashes for it to learn from."""

import json

import numpy as np
import safetensors.numpy

WIDTH, INNER = 16, 24
SIGNS = [*"abcdefghijklmnopqrstuvwxyz0123456789.,:;'-/()"]
WORDS = ["[PAD]", "[UNK]", "[CLS]", "[SEP]", *SIGNS, *(f"##{sign}" for sign in SIGNS)]
WORDS += ["north", "south", "east", "west", "##bound", "car", "van", "hit", "the", "left", "right", "was", "on"]


def write_bert(folder, layers=1, positions=512):
    """Write the files of a small encoder with drawn weights."""
    folder.mkdir(exist_ok=True)
    generator = np.random.default_rng(1)

    def drawn(*sizes):
        return generator.normal(size=sizes, scale=0.2).astype(np.float32)

    tensors = {
        "embeddings.word_embeddings.weight": drawn(len(WORDS), WIDTH),
        "embeddings.position_embeddings.weight": drawn(positions, WIDTH),
        "embeddings.token_type_embeddings.weight": drawn(2, WIDTH),
        "embeddings.LayerNorm.weight": np.ones(WIDTH, np.float32),
        "embeddings.LayerNorm.bias": np.zeros(WIDTH, np.float32),
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
                f"{own}{name}.weight": np.ones(WIDTH, np.float32),
                f"{own}{name}.bias": np.zeros(WIDTH, np.float32),
            }
    settings = {
        "hidden_size": WIDTH,
        "num_hidden_layers": layers,
        "num_attention_heads": 2,
        "intermediate_size": INNER,
        "max_position_embeddings": positions,
        "hidden_act": "gelu",
    }
    (folder / "config.json").write_text(json.dumps(settings))
    (folder / "vocab.txt").write_text("\n".join(WORDS) + "\n")
    safetensors.numpy.save_file(tensors, folder / "model.safetensors")
    return folder


TEXT = "A car was northbound on Elm. A van was westbound on Oak and hit the car in the left side. It was raining."
KEY = {
    "road_type": "Intersection",
    "num_lanes": 2,
    "stem_direction": None,
    "vehicles": [
        {"model": "Sedan", "initial_position": "S2N", "action": "Move Forward", "speed_limit_mph": None},
        {"model": "Minivan", "initial_position": "E2W", "action": "Move Forward", "speed_limit_mph": None},
    ],
    "env": {"time": None, "weather": "Rainy"},
    "collisions": [{"striking": 2, "struck": 1, "striking_side": "front", "struck_side": "right"}],
}


def write_told(path, count=6, **changes):
    """Write a file of told crashes, all alike."""
    content = {"text": TEXT, "key": KEY, "called": [["A car", "the car"], ["A van"]]} | changes
    lines = [json.dumps(content | {"author": "ann" if at % 2 else "bob", "name": f"{at:02}"}) for at in range(count)]
    path.write_text("\n".join(lines) + "\n")
    return path
