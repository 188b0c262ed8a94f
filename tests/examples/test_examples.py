"""Each example runs, does what it says, and is as short as the documentation promises."""

import ast
import io
import re
import runpy
import shutil
import subprocess
import sys
import tokenize
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "src" / "examples"
LINES = {"cruise": 10, "late_brake": 15, "train_ppo": 25, "evaluate_own": 10, "interventions": 8}
_LAYOUT = {
    tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENCODING,
    tokenize.ENDMARKER,
}  # fmt: skip


def lines_of_code(text):
    """Lines with anything but layout, comments and docstrings."""
    lines = {
        line
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type not in _LAYOUT
        for line in range(token.start[0], token.end[0] + 1)
    }
    for node in ast.walk(ast.parse(text)):
        body = getattr(node, "body", None)
        first = body[0] if isinstance(body, list) and body else None
        if isinstance(first, ast.Expr) and isinstance(first.value, ast.Constant) and isinstance(first.value.value, str):
            lines -= {*range(first.lineno, first.end_lineno + 1)}
    return len(lines)


def test_lines_are_counted_strictly():
    assert (
        lines_of_code('"""A\nB."""\n# c\n\nx = [\n    1,  # d\n]\n\n\ndef f():\n    """E."""\n    return """\n\n"""\n')
        == 7
    )


@pytest.mark.parametrize(("name", "most"), LINES.items())
def test_it_is_as_short_as_promised(name, most):
    text = (EXAMPLES / f"{name}.py").read_text(encoding="utf-8")
    assert lines_of_code(text) <= most
    assert ";" not in re.sub(r'"[^"]*"', "", text.partition('"""\n')[2].partition('"""\n')[2])  # one statement a line


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty folder to be in, from which the examples are found."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path, str(EXAMPLES)])
    return tmp_path


def main_of(name):
    return runpy.run_path(str(EXAMPLES / f"{name}.py"))["main"]


def test_the_policy_reaches_the_goal_and_keeps_its_gap(here):
    from roadmend import EventKind, run, sample_scenario

    class_of = runpy.run_path(str(EXAMPLES / "cruise.py"))["Cruise"]
    speeds = []
    result = run(
        sample_scenario("S3", 3), class_of(), "none", watch=lambda tick, *_: speeds.append(tick.scene.ego.speed)
    )
    assert result.outcome is EventKind.GOAL
    assert 8.0 < max(speeds) < 13.0


def test_the_repair_method_prevents_a_collision_and_its_parameter_counts(here):
    from roadmend import Command, Decision, EventKind, Trajectory, run, sample_scenario

    class_of = runpy.run_path(str(EXAMPLES / "late_brake.py"))["LateBrake"]

    class Push:
        name = "push"

        def reset(self, route):
            pass

        def step(self, scene):
            return Decision(Command(0.6, 0.0, change_lane=True), Trajectory.empty())

    collided = next(
        scenario
        for scenario in (sample_scenario("S4", number) for number in range(40))
        if run(scenario, Push(), "none").outcome is EventKind.COLLISION
    )
    times = [
        run(collided, Push(), class_of, repair_parameters={"time": time}).interventions for time in (0.1, 2.0, 4.0)
    ]
    assert times[0] < times[1] < times[2]


@pytest.mark.slow
def test_the_evaluation_prints_its_table_and_writes_its_page(here, capsys):
    from roadmend import sample_scenario

    scenarios = [sample_scenario("S3", number).model_copy(update={"time_limit": 3.0}) for number in (3, 4)]
    main_of("evaluate_own")(scenarios, "told")
    *table, page = capsys.readouterr().out.splitlines()
    assert [row.split(" | ")[1] for row in table[2:]] == ["none", "random", "late_brake:LateBrake", "rss"]
    text = (here / page).read_text()
    assert "<td>cruise:Cruise</td>" in text
    assert len((here / "told" / "results.jsonl").read_text().splitlines()) == 1 + 8


def test_the_interventions_of_a_bag_are_shown(here):
    for bag, said in (("repaired", ("because_of", "policy_action")), ("collision", ("Empty DataFrame",))):
        command = [sys.executable, str(EXAMPLES / "interventions.py"), str(ROOT / "bags" / "samples" / bag)]
        done = subprocess.run(command, capture_output=True, text=True, timeout=200, check=False)
        assert done.returncode == 0, done.stderr
        assert all(word in done.stdout for word in said), done.stdout


@pytest.mark.slow
def test_ppo_learns_for_some_steps_and_what_was_learned_is_measured(here):
    shutil.copy(EXAMPLES / "train_ppo.py", here)
    done = subprocess.run(
        [sys.executable, "train_ppo.py", "64", "2", "1", "2"], capture_output=True, text=True, timeout=280, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "total_timesteps" in done.stdout
    rows = [line.split(" | ") for line in done.stdout.splitlines() if ":LearnedPolicy" in line]
    assert [row[1] for row in rows] == ["none", "random", "rss"]
    assert (here / "ppo.zip").exists()


@pytest.mark.slow
def test_the_rates_are_printed(here, capsys):
    main_of("steps_per_second")(40, 1)
    lines = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in lines] == [
        "the runner, in this process", "one environment, in this process", "1 worker", "2 workers",
        "the runner, by its processor time", "one environment, by its processor time",
    ]  # fmt: skip
    assert all(re.search(r": \d+ steps/s \(", line) for line in lines)
