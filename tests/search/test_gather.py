"""Gathering a corpus in a made-up world: full, disjoint, the same however it is done, and honest about what is missing."""

import itertools
import json
import random
from pathlib import Path

import pytest
import yaml

from roadmend.core.errors import InputError
from roadmend.core.outcome import Blame
from roadmend.search.attempt import Attempt
from roadmend.search.corpus_plan import FRESH_SEED, CorpusPlan, fresh_plan, read_corpus_plan
from roadmend.search.evaluation import BEST
from roadmend.search.gather import gather, gather_fresh
from roadmend.search.ledger import Ledger
from roadmend.world.corpus import dump_corpus
from roadmend.world.families import FAMILIES
from roadmend.world.point_text import used_parameters
from tests.measures.results import episode

from .toy import made_up

CONFIG = Path(__file__).parents[2] / "config" / "search" / "corpus.yaml"
CYCLE = ["random", "avfuzzer"]


def chance(family, parameters, seed):
    """Every fifth or so collides, by what the scenario depends on; some of them are not to blame."""
    value = random.Random(f"{family} {seed} {sorted(parameters.items())}").random()
    return ("COLLISION" if value < 0.25 else "GOAL" if value < 0.9 else "TIMEOUT"), f"{value}"


def blame_of(digest):
    return Blame.FRONT if float(digest) < 0.2 else Blame.EGO_STOOD


def plan(**changes):
    def split(**own):
        values = {"violations": 4, "successes": 4, "techniques": CYCLE, "budget": 30, "least_distance": 0.01}
        plain = {"parameters": {}, "most_per_campaign": None, "futures": 0, "least_persistence": 0.0}
        return plain | values | own

    return CorpusPlan.model_validate(
        {
            "most_campaigns": 6,
            "test": split(first_seed=100, most_per_campaign=2),
            "validation": split(first_seed=200, most_per_campaign=3),
            "training": split(first_seed=300, violations=9, successes=11),
        }
        | changes
    )


@pytest.fixture(autouse=True)
def world(monkeypatch):
    """Counts of points that were searched and cases that were run again."""
    counts = {"searched": 0, "rerun": 0, "futures": 0}

    def evaluate(subject, point):
        counts["searched"] += 1
        used = used_parameters(FAMILIES[subject.family].build, point.parameters, subject.seed)
        outcome, digest = chance(subject.family, used, subject.seed)
        fitness = BEST if float(digest) < 0.2 else -float(digest)
        return made_up(outcome, digest, fitness, (float(digest),), blame_of(digest))

    def again(policy, case):
        counts["rerun"] += 1
        outcome, digest = chance(case.family, case.parameters, case.seed)
        return Attempt(episode(outcome, digest=digest, blame=blame_of(digest)), "")

    def persistence(question):
        counts["futures"] += question.count
        return round(random.Random(question.case.digest).random(), 2)

    monkeypatch.setattr("roadmend.search.persistence._answer", persistence)
    monkeypatch.setattr("roadmend.search.gather.evaluate", evaluate)
    monkeypatch.setattr("roadmend.search.rerun.rerun", again)
    return counts


def build(folder, families=("S1", "S5"), chosen=None, **options):
    return gather(chosen or plan(), "modular", families, folder, 1, **options)


def test_every_split_is_filled_from_its_own_searches(tmp_path):
    gathered = build(tmp_path)
    corpus = gathered.corpus
    assert not gathered.shortages
    for family in ("S1", "S5"):
        for name, split in plan().splits():
            cases = corpus.select(family, name)
            assert sum(case.is_violation for case in cases) == split.violations
            assert sum(case.outcome == "GOAL" for case in cases) == split.successes
            assert all(0 <= case.search_seed - split.first_seed < 6 for case in cases)
            assert all(case.seed == case.search_seed for case in cases)
            taken = [case.search_seed for case in cases if case.is_violation]
            assert max(map(taken.count, taken)) <= (split.most_per_campaign or 9)
            fair = [[case.search_seed for case in cases if not case.is_violation].count(seed) for seed in {*taken}]
            assert max(fair) - min(fair) <= 1
    assert not corpus.select("S2")
    assert len({case.digest for case in corpus.cases}) == len(corpus.cases) == 2 * plan().wanted
    assert len({case.name for case in corpus.cases}) == len(corpus.cases)
    assert {case.duration for case in corpus.cases} == {10.0}
    assert all(Blame[case.blame].is_egos for case in corpus.cases if case.is_violation)
    assert list((tmp_path / "modular" / "S1" / "test-0" / "found").iterdir())


def test_points_of_one_search_are_apart(tmp_path):
    far = plan(training={**plan().training.model_dump(), "least_distance": 0.1, "techniques": ["avfuzzer"]})
    cases = build(tmp_path, ["S1"], far).corpus.select("S1", "training", violation=True)
    assert len(cases) == 9
    for place, one in enumerate(cases):
        for other in cases[:place]:
            if one.search_seed == other.search_seed:
                keys = {**one.parameters, **other.parameters}
                assert sum(one.parameters.get(key) != other.parameters.get(key) for key in keys) > 1


def test_violations_that_come_in_few_futures_are_left_out(tmp_path, world):
    split = {**plan().test.model_dump(), "futures": 10, "least_persistence": 0.5, "most_per_campaign": 4}
    gathered = build(tmp_path, ["S1"], plan(test=split))
    violations = gathered.corpus.select("S1", "test", violation=True)
    assert len(violations) == 4
    assert all(case.persistence >= 0.5 for case in violations)
    assert gathered.corpus.fleeting > 0
    assert world["futures"] == 10 * (4 + gathered.corpus.fleeting)
    told = {case.persistence for case in gathered.corpus.cases if case not in violations}
    assert told == {None}  # of successes, and where nobody asked
    world["futures"] = 0
    assert build(tmp_path, ["S1"], plan(test=split)) == gathered
    assert world["futures"] == 0


def test_the_same_however_often_it_is_interrupted(tmp_path, world):
    whole = build(tmp_path / "whole").corpus
    effort = dict(world)

    class StoppedError(Exception):
        pass

    for most in (0, 1, 17, 40, 200):
        calls = 0

        def report(_progress, most=most):
            nonlocal calls
            calls += 1
            if calls > most:
                raise StoppedError

        with pytest.raises(StoppedError):
            build(tmp_path / "pieces", report=report)
    pieces = build(tmp_path / "pieces").corpus
    assert dump_corpus(pieces) == dump_corpus(whole)
    assert world["searched"] <= 2 * effort["searched"] + 5
    before = dict(world)
    assert dump_corpus(build(tmp_path / "pieces").corpus) == dump_corpus(whole)
    assert world == before  # nothing is searched or run again


def test_each_family_gets_the_same_alone(tmp_path):
    both = build(tmp_path / "both").corpus
    assert build(tmp_path / "one", ["S5"]).corpus.cases == tuple(both.select("S5"))


def test_progress_is_reported(tmp_path):
    seen = []
    build(tmp_path, ["S1"], report=seen.append)
    assert [progress.accepted for progress in seen] == sorted(progress.accepted for progress in seen)
    assert seen[-1].wanted == plan().wanted
    assert all(0 <= progress.done <= progress.total for progress in seen)
    assert {progress.stage for progress in seen} >= {"S1/test-0 random", "S1 test: run again"}


def test_what_does_not_come_to_the_same_is_dropped_and_counted(tmp_path, monkeypatch):
    good = build(tmp_path / "good", ["S1"]).corpus
    doomed = {case.digest for case in good.select("S1", "test")[::2]}

    def unsteady(policy, case):
        outcome, digest = chance(case.family, case.parameters, case.seed)
        return Attempt(episode(outcome, digest="other" if digest in doomed else digest), "")

    monkeypatch.setattr("roadmend.search.rerun.rerun", unsteady)
    gathered = build(tmp_path / "bad", ["S1"])
    assert not doomed & {case.digest for case in gathered.corpus.cases}
    assert 0 < gathered.corpus.dropped <= len(doomed)
    assert len(gathered.corpus.select("S1", "test")) == 8  # others take their place


def test_a_partial_corpus_searches_nothing(tmp_path, world):
    nothing = build(tmp_path, ["S1"], is_partial=True)
    assert not nothing.corpus.cases
    assert "S1 training: 0 of 9 violations after 0 searches" in nothing.shortages
    build(tmp_path, ["S1"], plan(training={**plan().training.model_dump(), "violations": 0, "successes": 0}))
    with Ledger(tmp_path / "modular" / "S1" / "training-0", plan().training.campaign("S1", "modular", 0).settings):
        pass  # a search that has not begun
    before = world["searched"]
    partial = build(tmp_path, ["S1"], is_partial=True)
    assert world["searched"] == before
    complete = build(tmp_path, ["S1"]).corpus
    assert partial.corpus.cases == tuple(case for case in complete.cases if case.split != "training")
    assert {case.split for case in partial.corpus.cases} == {"test", "validation"}
    assert partial.shortages == (
        "S1 training: 0 of 9 violations after 1 searches",
        "S1 training: 0 of 11 successes after 1 searches",
    )


def test_a_search_in_use_is_waited_for_unless_partial(tmp_path):
    build(tmp_path, ["S1"])
    with Ledger(tmp_path / "modular" / "S1" / "test-0", plan().test.campaign("S1", "modular", 0).settings):
        with pytest.raises(InputError, match="another process is at work"):
            build(tmp_path, ["S1"])
        assert all(case.search_seed != 100 for case in build(tmp_path, ["S1"], is_partial=True).corpus.cases)


def test_too_few_violations_are_told(tmp_path):
    scarce = plan(most_campaigns=1)
    gathered = build(tmp_path, ["S1"], scarce)
    assert "S1 test: 2 of 4 violations after 1 searches" in gathered.shortages
    assert len(gathered.corpus.select("S1", "test", violation=True)) == 2


def test_a_line_that_was_cut_short_is_run_again(tmp_path, world):
    whole = build(tmp_path, ["S1"]).corpus
    path = tmp_path / "modular" / "reruns.jsonl"
    path.write_bytes(path.read_bytes()[:-7])
    before = world["rerun"]
    assert build(tmp_path, ["S1"]).corpus == whole
    assert world["rerun"] == before + 1
    assert all(json.loads(line)["result"]["digest"] for line in path.read_text().splitlines()[1:])


def test_fresh_sets_use_seeds_of_their_own(tmp_path):
    first, again, other = (gather_fresh("modular", seed, 3, tmp_path, 1, families=["S1"]).corpus for seed in (7, 7, 8))
    assert first == again
    assert first.digest != other.digest
    assert {case.split for case in first.cases} == {"test"}
    assert len(first.select(violation=True)) == len(first.select(violation=False)) == 3
    assert {case.search_seed // 1000 for case in first.cases} == {10_007}
    assert not {case.digest for case in first.cases} & {case.digest for case in other.cases}


@pytest.mark.parametrize(("seed", "cases"), [(-1, 10), (10**7, 10), (0, 0), (0, 10**6)])
def test_fresh_numbers_out_of_range_are_refused(seed, cases):
    with pytest.raises(InputError, match="out of range"):
        fresh_plan(seed, cases)


def test_the_file_holds_the_defaults():
    assert read_corpus_plan(CONFIG) == CorpusPlan() == read_corpus_plan(None)
    assert [*yaml.safe_load(CONFIG.read_text())] == [*CorpusPlan.model_fields]


@pytest.mark.parametrize("name", ["test", "validation", "training"])
def test_what_a_file_leaves_out_of_a_split_is_as_by_that_splits_default(tmp_path, name):
    (tmp_path / "plan.yaml").write_text(f"{name}: {{violations: 5, techniques: [random]}}")
    plan = read_corpus_plan(tmp_path / "plan.yaml").model_dump()
    default = CorpusPlan().model_dump()
    assert plan == {**default, name: {**default[name], "violations": 5, "techniques": ("random",)}}


def test_a_share_of_futures_without_futures_is_refused(tmp_path):
    (tmp_path / "plan.yaml").write_text("test: {futures: 0}")
    with pytest.raises(
        InputError, match=r"field test: least_persistence 0\.8 needs futures, of which there are 0; see"
    ):
        read_corpus_plan(tmp_path / "plan.yaml")


def test_seeds_of_the_splits_never_meet():
    default = CorpusPlan()
    ranges = [range(split.first_seed, split.first_seed + default.most_campaigns) for _, split in default.splits()]
    ranges.append(range(FRESH_SEED, 2**31))
    ranges.sort(key=lambda one: one.start)
    assert all(one.stop <= other.start for one, other in itertools.pairwise(ranges))


@pytest.mark.parametrize(
    "text",
    [
        "[]",
        "a: [",
        "tests: {}",
        "most_campaigns: 0",
        "test: {budget: 0}",
        "test: {bugdet: 3}",
        "test: 3",
        "validation: {futures: 0, least_persistence: 0.8}",
        "test: {violations: 1, successes: 1, first_seed: 1, techniques: [magic], budget: 1, least_distance: 0.1}",
        "test: {violations: 1, successes: 1, first_seed: 1, techniques: [], budget: 1, least_distance: 0.1}",
        "test: {violations: 1, successes: 1, first_seed: 1, techniques: [random], budget: 1, least_distance: 2.0}",
        "most_campaigns: 3\ntest: {parameters: {random: {bacth: 1}}}",
    ],
)
def test_a_bad_plan_is_refused_in_one_line(tmp_path, text):
    (tmp_path / "plan.yaml").write_text(text)
    with pytest.raises(InputError) as caught:
        read_corpus_plan(tmp_path / "plan.yaml")
    assert "\n" not in str(caught.value)
