"""The index against a comparison with every vector."""

import numpy as np
import pytest

from harness.generated import generate
from harness.retrieval import draw_patterns
from roadmend.sera.latent import fit_latent
from roadmend.sera.vector_index import VectorIndex

COUNT, QUERIES = 12_000, 60


@pytest.fixture(scope="module")
def embedded():
    descriptors = [each.descriptor for each in generate(COUNT, 1)]
    embedder = fit_latent(descriptors[:3000])
    return embedder.embed(descriptors), embedder.embed(draw_patterns(QUERIES, 2))


@pytest.fixture(scope="module")
def index(embedded):
    return VectorIndex.build(embedded[0].astype(np.float16))


def recall(index, vectors, queries, allowed=None):
    shares = []
    for query in queries:
        scores = vectors @ query if allowed is None else np.where(allowed, vectors @ query, -np.inf)
        last = np.sort(scores)[-10]
        found, _ = index.search(query, 10, allowed)
        assert allowed is None or allowed[found].all()
        # Compared by score: of scenarios with equal scores, either may come last.
        shares.append(np.mean(scores[found] >= last - 1e-6))
    return np.mean(shares)


def test_recall_against_brute_force(index, embedded):
    assert index.codes is not None
    assert recall(index, *embedded) >= 0.99


@pytest.mark.parametrize("share", [0.5, 0.01])
def test_recall_under_a_filter(index, embedded, share):
    allowed = np.random.default_rng(0).uniform(size=COUNT) < share
    assert recall(index, *embedded, allowed) >= 0.99


def test_it_survives_storage_bit_by_bit(index, embedded):
    again = VectorIndex.load(index.vectors, index.dump_codes())
    for query in embedded[1][:10]:
        for one, other in zip(index.search(query, 10), again.search(query, 10), strict=True):
            np.testing.assert_array_equal(one, other)


def test_few_vectors_are_compared_exactly_and_ties_go_by_number(embedded):
    vectors = np.repeat(embedded[0][:40].astype(np.float16), 3, axis=0)
    few = VectorIndex.build(vectors)
    assert few.codes is None
    found, scores = few.search(embedded[0][7], 4)
    assert found[:3].tolist() == [21, 22, 23]
    assert scores[0] == scores[2] > scores[3]


def test_an_odd_number_of_dimensions_is_no_matter(embedded):
    vectors = embedded[0][:, :-1]
    odd = VectorIndex.build(vectors.astype(np.float16))
    assert recall(odd, vectors, embedded[1][:20, :-1]) >= 0.99
