"""``roadmend safe extract``: files, resumption, tables, and reports that are none."""

import json

import pytest

from roadmend.cli.main import main
from roadmend.core.resources import config_folder
from roadmend.safe.dsl_data import dump_data
from roadmend.safe.dsl_file import load_crash_scenario
from roadmend.safe.reading.reader import read_summary

from ..language.server import completion, serving  # noqa: TID252 - one server for three rooms

REPORTS = config_folder() / "reports"


def read(capsys, *arguments):
    code = main(["safe", "extract", *map(str, arguments), "--workers", "2", "--json"])
    return code, json.loads(capsys.readouterr().out)["reports"]


def test_a_folder_of_reports(tmp_path, capsys):
    code, done = read(capsys, REPORTS, "--out", tmp_path)
    assert code == 0
    cases = ["curve", "intersection", "merging", "straight", "t-intersection"]
    assert [each["case"] for each in done] == cases
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        name for case in cases for name in (f"{case}.json", f"{case}.evidence.json")
    )
    assert load_crash_scenario(tmp_path / "curve.json").road.road_type == "Curve"
    evidence = json.loads((tmp_path / "curve.evidence.json").read_text())
    assert evidence["fields"]["env.weather"]["value"] == "Snowy"
    assert evidence["fields"]["env.weather"]["sentence"] in (REPORTS / "curve" / "summary.txt").read_text()
    first, *others = evidence["notes"]
    assert first == "the report has no sketch"
    assert all("is in doubt" in each for each in others)


def test_pages_are_written_where_they_are_wanted(tmp_path, capsys):
    read(capsys, REPORTS / "t-intersection", "--out", tmp_path)
    assert not (tmp_path / "t-intersection.html").exists()
    _, done = read(capsys, REPORTS / "t-intersection", "--out", tmp_path, "--page")
    assert [each["is_new"] for each in done] == [False]  # a page is made of what was kept, too
    page = (tmp_path / "t-intersection.html").read_text(encoding="utf-8")
    assert 'data-fields="stem_direction"' in page or 'data-field="stem_direction"' in page
    assert "as built, not driven" in page


def test_another_trained_reader_reads_anew(tmp_path, capsys, monkeypatch):
    read(capsys, REPORTS / "curve", "--out", tmp_path)
    monkeypatch.setattr("roadmend.safe.embedded.trained_reader", lambda: "crash-text of another training")
    _, done = read(capsys, REPORTS / "curve", "--out", tmp_path)
    assert [each["is_new"] for each in done] == [True]


def test_a_second_call_does_what_is_left(tmp_path, capsys):
    read(capsys, REPORTS, "--out", tmp_path)
    (tmp_path / "curve.json").unlink()
    (tmp_path / "merging.evidence.json").write_text("{")
    (tmp_path / "straight.json").write_text("{}")
    before = (tmp_path / "intersection.json").stat().st_mtime_ns
    _, done = read(capsys, REPORTS, "--out", tmp_path)
    assert [each["case"] for each in done if each["is_new"]] == ["curve", "merging", "straight"]
    assert (tmp_path / "intersection.json").stat().st_mtime_ns == before


def test_a_report_that_changed_is_read_again(tmp_path, capsys):
    report = tmp_path / "case.txt"
    report.write_text("V1, a van, was traveling north on a two-lane road at night and hit a tree.")
    assert read(capsys, report, "--out", tmp_path / "out")[1][0]["is_new"]
    assert not read(capsys, report, "--out", tmp_path / "out")[1][0]["is_new"]
    report.write_text("V1, a van, was traveling south on a two-lane road at night and hit a tree.")
    assert read(capsys, report, "--out", tmp_path / "out")[1][0]["is_new"]


def test_reports_that_are_none_do_not_stop_the_others(tmp_path, capsys):
    reports = tmp_path / "reports"
    reports.mkdir()
    (reports / "a-empty.txt").write_text("")
    (reports / "b-binary.txt").write_bytes(bytes(100))
    (reports / "c-german.txt").write_text(
        "Der Wagen fuhr nach Norden und stieß an der Kreuzung mit dem anderen Wagen zusammen, sagt er."
    )
    (reports / "d-fine.txt").write_text("V1, a van, was traveling north on a two-lane road at night and hit a tree.")
    code, done = read(capsys, reports, "--out", tmp_path / "out")
    assert code == 1
    assert ["is empty" in done[0]["error"], "is no text" in done[1]["error"], "English" in done[2]["error"]] == [
        True
    ] * 3
    assert done[3]["error"] is None
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["d-fine.evidence.json", "d-fine.json"]


def test_a_run_with_a_model_is_kept_without_the_key_and_replayed(tmp_path, capsys, monkeypatch):
    scenario = dump_data(read_summary((REPORTS / "curve" / "summary.txt").read_text()).scenario)
    answers = {
        "meta_message": {
            "analysis": "",
            "road_type": "Curve",
            "number_of_vehicles": 2,
            "driving_directions": ["W2E", "E2W"],
        },
        "scenario": {"analysis": "", "scenario": scenario},
        "validation": {"verdict": "Pass", "problems": []},
    }
    monkeypatch.setenv("OPENAI_API_KEY", "sk-very-secret-4711")
    with serving(lambda body: completion(json.dumps(answers[body["response_format"]["json_schema"]["name"]]))) as (
        _,
        url,
    ):
        monkeypatch.setenv("OPENAI_BASE_URL", url)
        code, done = read(capsys, REPORTS / "curve", "--out", tmp_path / "asked", "--backend", "openai")
    assert (code, done[0]["scenario"]) == (0, scenario)
    files = sorted((tmp_path / "asked").iterdir())
    assert [path.name for path in files] == ["curve.evidence.json", "curve.exchanges.jsonl", "curve.json"]
    assert not any("sk-very-secret" in path.read_text() for path in files)
    monkeypatch.delenv("OPENAI_API_KEY")
    replay = ("--backend", "replay", "--recording", tmp_path / "asked")
    code, done = read(capsys, REPORTS / "curve", "--out", tmp_path / "again", *replay)
    assert (code, done[0]["scenario"]) == (0, scenario)
    code, done = read(capsys, REPORTS / "straight", "--out", tmp_path / "again", *replay)
    assert code == 1
    assert "recording has no" in done[0]["error"]


class TestUsage:
    """What a model took: the server counts 1000 tokens in and 50 out for each answer."""

    @pytest.fixture
    def ask(self, tmp_path, capsys, monkeypatch):
        monkeypatch.setenv("OPENAI_API_KEY", "secret")
        refused = {"verdict": "Fail", "problems": ["no"]}

        def run(*more, prices=True):
            settings = tmp_path / "openai.yaml"
            settings.write_text("input_price: 2.0\noutput_price: 10.0\n" if prices else "attempts: 1\n")
            meta = {
                "analysis": "",
                "road_type": "Curve",
                "number_of_vehicles": 1,
                "driving_directions": ["W2E"],
            }
            answers = {"meta_message": meta, "validation": refused}
            with serving(
                lambda body: completion(json.dumps(answers[body["response_format"]["json_schema"]["name"]]))
            ) as (
                _,
                url,
            ):
                monkeypatch.setenv("OPENAI_BASE_URL", url)
                given = ("--out", tmp_path / "out", "--backend", "openai", "--settings", settings, "--attempts", "2")
                given += ("--no-cross-check",)
                assert main(["safe", "extract", *map(str, (REPORTS, *given, *more))]) == 1
            return capsys.readouterr().out

        return run

    def test_answers_that_were_rejected_count(self, ask):
        said = json.loads(ask("--json"))
        each = {"answers": 4, "input_tokens": 4000, "output_tokens": 200}
        assert all(report["usage"]["test-model-1"].items() >= each.items() for report in said["reports"])
        total = said["usage"]["test-model-1"]
        assert total == {"answers": 20, "input_tokens": 20_000, "output_tokens": 1000, "cost": pytest.approx(0.05)}

    def test_the_summary(self, ask):
        assert "test-model-1: 20 answers, 20,000 tokens in, 1,000 out, 0.0500 US dollars" in ask()

    def test_without_prices_there_is_no_cost(self, ask):
        assert "test-model-1: 20 answers, 20,000 tokens in, 1,000 out\n" in ask(prices=False)
        assert json.loads(ask("--json", prices=False))["usage"]["test-model-1"]["cost"] is None


def test_rules_take_no_tokens(tmp_path, capsys):
    assert main(["safe", "extract", str(REPORTS), "--out", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["usage"] == {}


def test_the_table(tmp_path, capsys):
    assert main(["safe", "extract", str(REPORTS), "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "T-intersection West" in shown
    assert "SUV On-ramp Move Forward, Semi Truck Main road Move Forward" in shown
    assert "5 of 5 read (0 by an earlier call)" in " ".join(shown.split())


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["missing"], "no such report"),
        ([REPORTS, "--backend", "replay"], "has no recording"),
        ([REPORTS, "--backend", "replay", "--recording", "missing"], "missing"),
        ([REPORTS, "--backend", "openai", "--settings", "missing.yaml"], "missing.yaml"),
        ([REPORTS, "--backend", "magic"], "there is no 'magic'; choose one of"),
        ([REPORTS, "--attempts", "0"], "attempts"),
    ],
)
def test_bad_arguments_are_one_line(arguments, complaint, tmp_path, capsys, monkeypatch):
    monkeypatch.setenv("OPENAI_API_KEY", "secret")
    assert main(["safe", "extract", *map(str, arguments), "--out", str(tmp_path / "out")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert complaint in line
    assert not (tmp_path / "out").exists()
