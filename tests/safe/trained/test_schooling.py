"""The training of the trained reader, small: it learns, goes on where it stopped, and reads the same without torch."""

import json
import random
from collections.abc import Iterator

import numpy as np
import pytest
import torch

from roadmend.core.errors import InputError
from roadmend.networks.checkpoint import save_checkpoint
from roadmend.networks.tensors import restored
from roadmend.safe.reading.reader import read_claims
from roadmend.safe.trained.crash_network import KIND, CrashNetwork, head_shapes
from roadmend.safe.trained.lessons import lesson_of, names_by_words
from roadmend.safe.trained.marked_text import MARKS, mark_text
from roadmend.safe.trained.outputs import OF_PAIR, OF_PIECE, OF_TEXT, OF_VEHICLE, shares_of
from roadmend.safe.trained.schooling import Schooling, school
from roadmend.safe.trained.told_crashes import named_told, read_told
from roadmend.safe.trained.trained_claims import TrainedReader
from roadmend.safe.trained.word_pieces import WordPieces
from roadmend.training.text_reading import TextNetwork
from tests.networks.small_bert import WORDS, write_bert
from tests.safe.trained.told import KEY, TEXT, write_told

SETTINGS = Schooling(made_up=16, beside=4, epochs=3, batch=4, pieces=100, held_out=("bob",))
CRASH = names_by_words(TEXT, [["A car", "the car"], ["A van"]])


def untold(stage, done, of, loss):
    pass


def learn(folder, settings=SETTINGS, watch=untold, work="work", seed=0):
    told = read_told(write_told(folder / "told.jsonl"))
    write_bert(folder / "bert")
    return school(told, folder / "bert", settings, seed, folder / work, map, watch)


def saved(schooled, path):
    save_checkpoint(path, schooled.tensors, {**schooled.header, "kind": KIND})
    return path


@pytest.fixture(scope="module")
def schooled(tmp_path_factory):
    return learn(tmp_path_factory.mktemp("schooled"))


@pytest.fixture(scope="module")
def network(schooled, tmp_path_factory):
    return CrashNetwork(saved(schooled, tmp_path_factory.mktemp("network") / "small.safetensors"))


def test_what_authors_wrote_who_are_held_out_is_measured_on(schooled):
    metrics = schooled.header["metrics"]
    assert (metrics["lessons"], metrics["held_out"]) == (3, 3)
    assert {"heading", "relation", "road_type", "weather"} <= {*metrics}
    assert "ramp" not in metrics
    assert "stem" not in metrics


def test_it_learns(tmp_path):
    losses = []
    learn(
        tmp_path,
        SETTINGS.model_copy(update={"made_up": 0, "beside": 0, "epochs": 60, "learning_rate": 2e-3, "dropout": 0.0}),
        lambda stage, done, of, loss: losses.append(loss) if stage == "told crashes" else None,
    )
    assert np.mean(losses[-10:]) < 0.6 * np.mean(losses[:10])


def test_the_same_settings_give_the_same_weights_however_often_it_stopped(schooled, tmp_path):
    class StoppedError(Exception):
        pass

    def stop_in(wanted: str) -> Iterator[None]:
        def watch(stage, done, of, loss):
            if stage == wanted and done == of - 1:
                raise StoppedError

        return watch

    for stage in ("made-up crashes", "told crashes"):
        with pytest.raises(StoppedError):
            learn(tmp_path, watch=stop_in(stage))
    again = learn(tmp_path)
    assert all((again.tensors[name] == value).all() for name, value in schooled.tensors.items())
    other = learn(tmp_path, work="other", seed=1)
    assert any((other.tensors[name] != value).any() for name, value in schooled.tensors.items())


def test_the_state_of_another_training_is_refused(tmp_path):
    learn(tmp_path)
    for change in ({"seed": 1}, {"settings": SETTINGS.model_copy(update={"held_out": ("ann",)})}):
        with pytest.raises(InputError, match="made-up-crashes: holds a training of other texts, settings, seed"):
            learn(tmp_path, **change)
    learn(tmp_path, SETTINGS.model_copy(update={"trust": {**SETTINGS.trust, "heading": 0.3}}))  # teaches nothing else
    told = read_told(tmp_path / "told.jsonl")
    with pytest.raises(InputError, match="holds a training of other texts"):
        school(told[:-1], tmp_path / "bert", SETTINGS, 0, tmp_path / "work", map, untold)
    write_bert(tmp_path / "bert", layers=2)
    with pytest.raises(InputError, match="holds a training of other texts"):
        school(told, tmp_path / "bert", SETTINGS, 0, tmp_path / "work", map, untold)


def test_authors_who_are_held_out_have_written_something(tmp_path):
    with pytest.raises(InputError, match="held_out: bobby wrote none of the told crashes; choose of ann, bob"):
        learn(tmp_path, SETTINGS.model_copy(update={"held_out": ("bob", "bobby")}))


@pytest.mark.parametrize("change", [{"headng": 0.2}, {"heading": -0.1}, {"heading": 1.1}, {"heading": None}])
def test_trust_is_a_share_for_each_answer(change):
    trust = {name: share for name, share in {**SETTINGS.trust, **change}.items() if share is not None}
    with pytest.raises(ValueError, match="trust"):
        Schooling(trust=trust)


def test_it_reads_without_torch_as_with_it(schooled, network):
    shape = network.encoder.shape
    twin = TextNetwork(shape, head_shapes(shape.hidden)).eval()
    twin.load_state_dict({name: torch.from_numpy(value) for name, value in restored(schooled.tensors).items()})
    marked = mark_text(CRASH, network.pieces)
    inputs = [torch.from_numpy(each)[None] for each in (marked.pieces, marked.marks)]
    with torch.no_grad():
        logits = twin(*inputs, torch.ones_like(inputs[0], dtype=torch.bool), torch.from_numpy(marked.shares)[None])
    answers = network.answer(marked)
    for found, questions, own in zip(
        (answers.vehicles, answers.pairs, answers.text), (OF_VEHICLE, OF_PAIR, OF_TEXT), logits[:3], strict=True
    ):
        for name, shares in shares_of(own[0].numpy(), questions).items():
            assert np.abs(found[name] - shares).max() < 1e-4
    parties = shares_of(logits[3][0].numpy(), OF_PIECE)["party"]
    assert np.abs(network.parties(marked) - parties).max() < 1e-4


def test_a_text_longer_than_the_encoder_is_read_in_windows(network):
    size = network.encoder.shape.positions
    crash = names_by_words(f"{TEXT} " * 30, [["A car", "the car"], ["A van"]])
    marked = mark_text(crash, network.pieces)
    assert len(marked.pieces) > 2 * size
    states = network._states(marked)
    assert np.isfinite(states).all()
    assert (np.abs(states).sum(axis=1) > 0).all()
    short = mark_text(CRASH, network.pieces)
    assert (network._states(short) == network.encoder.read(short.pieces, short.marks)).all()


def test_claims_are_of_the_vehicles_by_their_place_and_turn_with_the_text(network):
    reader = TrainedReader(network)
    said = read_claims(TEXT)
    _, claims = reader.read(TEXT, said)
    paths = {claim.path for claim in claims if hasattr(claim, "path")}
    fields = ("initial_position", "action", "model")
    own = {f"vehicles[{place}].{field}" for place in (0, 1) for field in fields}
    texts = {"road_type", "stem_direction", "env.weather", "env.time", "num_lanes"}
    assert paths - {f"vehicles[{place}].speed_limit_mph" for place in (0, 1)} <= own | texts
    assert own | {"road_type", "stem_direction"} <= paths
    assert sum(hasattr(claim, "relation") for claim in claims) == 4
    assert {str(claim.source) for claim in claims} == {"trained reader"}
    before, after = reader.answers(CRASH), reader.answers(CRASH.turned(1))
    assert np.abs(np.roll(before.vehicles["heading"], 1, axis=-1) - after.vehicles["heading"]).max() < 1e-9
    assert np.abs(before.pairs["relation"] - after.pairs["relation"]).max() < 1e-9


def test_of_what_is_likely_not_told_nothing_is_claimed(network):
    reader = TrainedReader(network)
    answers = reader.answers(CRASH)
    for name, asked in ((each.name, each) for each in OF_TEXT if each.values[0] is None):
        shares = np.full(len(asked.values), 0.01)
        shares[0] = 1.0 - shares[1:].sum()
        answers.text[name] = shares
    claims = [each for each in reader._claims(frozenset(), answers, (0, 1)) if hasattr(each, "path")]
    assert {each.path for each in claims} >= {"road_type", "stem_direction"}
    assert not {each.path for each in claims} & {"env.time", "env.weather", "num_lanes"}


def test_a_limit_is_claimed_only_of_numbers_that_may_be_one(network):
    reader = TrainedReader(network)
    answers = reader.answers(CRASH)
    asked = next(each for each in OF_VEHICLE if each.name == "speed_limit")
    first, second = (value for value in asked.values[1:3])
    answers.vehicles["speed_limit"][0] = [0.5 * (value in {first, second}) for value in asked.values]
    claims = [each for each in reader._claims(frozenset({second}), answers, (0, 1)) if hasattr(each, "path")]
    assert {each.value for each in claims if each.path == "vehicles[0].speed_limit_mph"} == {second}


def test_names_are_those_of_the_rules_or_the_noted_ones(tmp_path):
    told = read_told(write_told(tmp_path / "told.jsonl", 1))[0]
    assert named_told(told).count == 2
    noted = read_told(write_told(tmp_path / "noted.jsonl", 1, text="It rained on A car and A van of glass."))[0]
    assert named_told(noted).names
    swapped = read_told(write_told(tmp_path / "swapped.jsonl", 1, called=[["A van"], ["A car", "the car"]]))[0]
    assert {TEXT[each.start : each.end]: each.vehicles for each in named_told(swapped).names}["A van"] == (0,)
    assert {TEXT[each.start : each.end]: each.vehicles for each in named_told(told).names}["A van"] == (1,)
    bare = read_told(write_told(tmp_path / "bare.jsonl", 1, text="It rained.", called=[]))[0]
    assert named_told(bare) is None


@pytest.mark.parametrize("line", ["{}", "[]", '{"author": "a", "name": "1", "text": "t", "key": {"vehicles": 3}}', "x"])
def test_a_line_that_is_no_told_crash_is_refused(tmp_path, line):
    path = tmp_path / "told.jsonl"
    path.write_text(line + "\n")
    with pytest.raises(InputError, match="line 1"):
        read_told(path)


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        ({"road_type": "Crossing"}, 'road_type: "Crossing" is none of Straight, Curve'),
        ({"env": {"weather": "raining hard"}}, 'env.weather: "raining hard" is none of'),
        ({"env": "rainy"}, "is no told crash"),
        ({"collisions": 3}, "is no told crash"),
        ({"collisions": [{"striking": "2", "struck": 1}]}, r'collisions\[0\].striking: "2" is no number'),
        ({"vehicles": [{"initial_position": "North"}]}, r'vehicles\[0\].initial_position: "North" is none of W2E'),
    ],
)
def test_a_key_that_the_scenario_language_does_not_have_is_refused(tmp_path, change, complaint):
    path = write_told(tmp_path / "told.jsonl", 1, key=KEY | change)
    with pytest.raises(InputError, match=rf"told\.jsonl, line 1: .*{complaint}"):
        read_told(path)


def test_a_text_with_its_key_beside_it_is_a_told_crash(tmp_path):
    path = tmp_path / "ann-07.txt"
    path.write_text(TEXT)
    with pytest.raises(InputError, match=r"ann-07\.oracle\.json"):
        read_told(path)
    path.with_name("ann-07.oracle.json").write_text(json.dumps(KEY))
    (found,) = read_told(path)
    assert (found.author, found.name, found.text) == ("ann", "07", TEXT)
    assert lesson_of(CRASH, found.key).draw(WordPieces(WORDS), 40, random.Random(0)).text.shape == (len(OF_TEXT),)


def test_a_model_of_something_else_is_refused(schooled, tmp_path):
    with pytest.raises(InputError, match="no model of crash texts"):
        CrashNetwork(saved_with(schooled, tmp_path / "a.safetensors", vocabulary=["[UNK]", "[CLS]", "[SEP]"]))
    with pytest.raises(InputError, match="no model of crash texts"):
        CrashNetwork(saved_with(schooled, tmp_path / "b.safetensors", vocabulary=3))
    with pytest.raises(InputError, match="shape"):
        CrashNetwork(saved_with(schooled, tmp_path / "c.safetensors", shape={"pieces": -1}))
    assert MARKS == 10
    with pytest.raises(InputError, match=r"d\.safetensors: does not say how far its answers about heading are trusted"):
        TrainedReader(CrashNetwork(saved_with(schooled, tmp_path / "d.safetensors", trust={"cast": 1.0})))


def saved_with(schooled, path, **changes):
    header = {**schooled.header, "kind": KIND, **changes}
    save_checkpoint(path, schooled.tensors, header)
    return path
