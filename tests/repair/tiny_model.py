"""A model of ADReFT with random weights, for tests that need any model at all."""

import numpy as np

from roadmend.networks.checkpoint import save_checkpoint
from roadmend.networks.shape import EncoderShape
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.repair.adreft.risk_monitor import RiskConfiguration

HIDDEN = 8
RISK = {"head": (6,), "threshold": 0.5, "horizon": 8.0}  # of a risk monitor


def configuration_of(tokenizer="paper", **changes):
    made = make_tokenizer(tokenizer)
    encoder = EncoderShape(attributes=made.attributes, hidden=HIDDEN, layers=1, heads=2, feed_forward=8)
    values = {"tokenizer": tokenizer, "tokenizer_version": made.version, "encoder": encoder, "monitor": (6,)}
    for name in ("need", "change"):
        if isinstance(changes.get(name), dict):
            changes[name] = RiskConfiguration(encoder=encoder, **changes[name])
    return ModelConfiguration(**{**values, "adapter": (6,), **changes})


def random_tensors(configuration, seed=0):
    numbers = np.random.default_rng(seed)
    encoder, tensors = configuration.encoder, {}

    def linear(name, outputs, inputs):
        tensors[f"{name}.weight"] = numbers.normal(0.0, inputs**-0.5, (outputs, inputs)).astype(np.float32)
        tensors[f"{name}.bias"] = numbers.normal(0.0, 0.1, outputs).astype(np.float32)

    def scene_encoder(name):
        linear(f"{name}.embed", encoder.hidden, encoder.attributes)
        tensors[f"{name}.cls"] = numbers.normal(0.0, 1.0, encoder.hidden).astype(np.float32)
        for place in range(encoder.layers):
            encoder_layer(f"{name}.layers.{place}")

    def encoder_layer(layer):
        linear(f"{layer}.attention_in", 3 * encoder.hidden, encoder.hidden)
        linear(f"{layer}.attention_out", encoder.hidden, encoder.hidden)
        linear(f"{layer}.feed_in", encoder.feed_forward, encoder.hidden)
        linear(f"{layer}.feed_out", encoder.hidden, encoder.feed_forward)
        for norm in ("norm1", "norm2"):
            tensors[f"{layer}.{norm}.weight"] = np.ones(encoder.hidden, np.float32)
            tensors[f"{layer}.{norm}.bias"] = np.zeros(encoder.hidden, np.float32)

    scene_encoder("encoder")
    heads = {"monitor": configuration.monitor_shape, "adapter": configuration.adapter_shape}
    for name, risk in configuration.risks.items():
        scene_encoder(f"{name}.encoder")
        heads[f"{name}.head"] = risk.head_shape
    for name, shape in heads.items():
        for place, (inputs, outputs) in enumerate(zip(shape.widths, shape.widths[1:], strict=False)):
            linear(f"{name}.layers.{place}", outputs, inputs)
    return tensors


def header_of(configuration, threshold=0.5, **changes):
    plain = configuration.model_dump(mode="json")
    header = {"kind": "adreft", "configuration": {"model": plain, "training": {}}, "threshold": threshold}
    return {**header, "data_digest": "", "metrics": {}, "ancestry": [], **changes}


def save_tiny_model(path, seed=0, threshold=0.5, **changes):
    configuration = configuration_of(**changes)
    save_checkpoint(path, random_tensors(configuration, seed), header_of(configuration, threshold))
    return path
