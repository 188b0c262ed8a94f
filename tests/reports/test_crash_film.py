"""Films of built scenarios: lanes, bodies and where everybody is, as a page plays them."""

import json

import pytest

from roadmend.reports.crash_film import film_beside, film_of_start, film_of_trial, load_film, save_film
from roadmend.safe.construction import CrashRole, draw_scenario
from roadmend.safe.trial import run_trial
from tests.safe.crashes import HEAD_ON
from tests.safe.lone import LONE, onlooker


@pytest.fixture(scope="module")
def scenario():
    return draw_scenario(CrashRole("head-on", HEAD_ON, 0), 0)


def test_a_scenario_as_it_is_built(scenario):
    film = film_of_start(scenario)
    assert film["vehicles"][0]["name"] == "v1"
    assert [time for time, _ in film["frames"]] == [0.0]
    assert film["frames"][0][1][0] is not None
    assert {lane["kind"] for lane in film["lanes"]} >= {"road"}


def test_a_run_ends_with_its_last_tick(scenario):
    trial = run_trial(scenario, "modular")
    film = film_of_trial(scenario, trial)
    times = [time for time, _ in film["frames"]]
    assert times == sorted(set(times))
    x, y, _ = film["frames"][-1][1][0]
    assert (x, y) == (round(trial.film.ego[-1].x, 2), round(trial.film.ego[-1].y, 2))
    assert film["collided"] is trial.summary.collided
    assert all(len(places) == len(film["vehicles"]) for _, places in film["frames"])


def test_what_stands_there_is_drawn_apart_from_vehicles():
    film = film_of_start(draw_scenario(onlooker(LONE["right"]), 0))
    assert [(each["name"], each.get("fixed", False)) for each in film["vehicles"]] == [
        ("ego", False),
        ("tree", True),
        ("v1", False),
    ]
    assert all(place is not None for place in film["frames"][0][1])


def test_a_film_is_kept_beside_its_picture(scenario, tmp_path):
    path = film_beside(tmp_path / "a-modular.png")
    assert path.name == "a-modular.film.json"
    film = film_of_start(scenario)
    save_film(film, path)
    assert load_film(path) == json.loads(json.dumps(film))


@pytest.mark.parametrize("text", [None, "", "{", "[]", '{"format": "other"}', '{"format": "roadmend-crash-film/1"}'])
def test_what_is_no_film_is_none(tmp_path, text):
    path = tmp_path / "a.film.json"
    if text is not None:
        path.write_text(text)
    assert load_film(path) is None


@pytest.mark.parametrize(
    "changed",
    [
        {"frames": []},
        {"frames": [[0.0, []]]},
        {"frames": [[0.0, [[0.0, 0.0, 0.0, 0.0]]]]},
        {"frames": [[float("nan"), [None]]]},
        {"vehicles": [{"name": "v1"}]},
        {"lanes": [{"kind": "road", "width": 3.0, "points": [1.0]}]},
        {"text": 3},
    ],
)
def test_a_film_that_was_altered_is_none(scenario, tmp_path, changed):
    path = tmp_path / "a.film.json"
    path.write_text(json.dumps({**film_of_start(scenario), **changed}))
    assert load_film(path) is None
