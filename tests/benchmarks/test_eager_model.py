"""The model in plain torch gives the answers that the compiled one gives."""

import numpy as np
import pytest

from harness.eager_model import EagerAdreftModel
from roadmend.repair.adreft.configuration import ModelConfiguration
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.registry import TOKENIZERS, make_tokenizer
from roadmend.training.adreft.network import AdreftNetwork
from roadmend.training.torch_state import tensors_of


@pytest.mark.parametrize("tokens", sorted(TOKENIZERS))
def test_agrees_with_the_compiled_model(tokens):
    tokenizer = make_tokenizer(tokens)
    configuration = ModelConfiguration(
        tokenizer=tokens, tokenizer_version=tokenizer.version, encoder={"attributes": tokenizer.attributes}
    )
    tensors = tensors_of(AdreftNetwork(configuration))
    tensors["need.x"] = np.zeros(3, np.float32)  # of a risk monitor; not timed, it is asked seldom
    compiled, eager = (kind(configuration, tensors, 0.5) for kind in (AdreftModel, EagerAdreftModel))
    values = np.random.default_rng(1).normal(size=(25, tokenizer.attributes)).astype(np.float32)
    ours, theirs = compiled.encode(values), eager.encode(values)
    np.testing.assert_allclose(ours, theirs[0].numpy(), rtol=0, atol=2e-5)
    assert compiled.score(ours, -0.3) == pytest.approx(eager.score(theirs, -0.3), abs=2e-5)
    np.testing.assert_allclose(compiled.values(ours, 0.4), eager.values(theirs, 0.4), rtol=0, atol=2e-5)
    assert eager.attention.shape == (25,)
