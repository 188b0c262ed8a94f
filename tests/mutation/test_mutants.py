"""What run.py beside this file changes, and what it leaves alone."""

import sys
from pathlib import Path

sys.path.append(str(Path(__file__).parent))
import mutants

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
