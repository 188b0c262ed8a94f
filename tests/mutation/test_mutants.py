"""What run.py beside this file changes, and what it leaves alone."""

import json
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parent))
import mutants
import targets

EXAMPLE = '''"""Nothing in here: 1.0 + 2.0."""

import math

LIMIT: float = 2.0  # [m]


@property
def reach(speed: float, factor: float = 1.0) -> float:
    """Nor in here: 1.0 + 2.0."""
    text = f"{speed + 1.0:.1f} m"
    if speed >= 0.0:
        print(text)
    return min(LIMIT, speed * factor) - math.sin(speed)
'''


def test_numbers_signs_limits_conditions_and_calls_are_changed_and_texts_are_not(tmp_path):
    file = tmp_path / "example.py"
    file.write_text(EXAMPLE, encoding="utf-8")
    found = mutants.find_mutants(file)
    named = {f"{mutant.line}: {mutant.after}" for mutant in found}
    assert named >= {
        "5: LIMIT: float = 2.1",
        "5: LIMIT: float = 3.0",
        "9: def reach(speed: float, factor: float = 1.05) -> float:",
        "11: pass",
        "12: if speed > 0.0:",
        "12: if not (speed >= 0.0):",
        "13: pass",
        "14: return max(LIMIT, speed * factor) - math.sin(speed)",
        "14: return min(LIMIT, speed / factor) - math.sin(speed)",
        "14: return min(LIMIT, speed * factor) + math.sin(speed)",
        "14: return min(LIMIT, speed * factor) - math.cos(speed)",
    }
    assert {mutant.line for mutant in found} == {5, 9, 11, 12, 13, 14}
    assert all(mutant.source != EXAMPLE for mutant in found)
    assert {mutant.line for mutant in mutants.find_mutants(file, ("reach",))} == {9, 11, 12, 13, 14}


SURVIVORS = json.loads(Path(__file__).with_name("survivors.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("target", targets.TARGETS, ids=lambda target: target.file)
def test_who_survived_is_still_a_mutant_and_has_a_reason(target):
    """Else a file was changed after the last whole run of run.py, and nobody knows what its tests would miss."""
    kept = SURVIVORS[target.file]
    found = mutants.find_mutants(target.path, target.functions, target.left_out)
    assert kept["mutants"] == len(found), "run tests/mutation/run.py --write"
    assert {*kept["survivors"]} <= {mutant.name for mutant in found}
    assert all(len(reason) > 10 for reason in kept["survivors"].values())


def test_the_score_of_all_is_above_the_bar():
    made = sum(kept["mutants"] for kept in SURVIVORS.values())
    lived = sum(len(kept["survivors"]) for kept in SURVIVORS.values())
    assert {*SURVIVORS} == {target.file for target in targets.TARGETS}
    assert 1.0 - lived / made >= targets.BAR
