"""What the paper reports (ADReFT, tables 1 to 5), to stand beside ours: other simulator, other policies."""

from typing import Any

POLICIES = {"modular": "Pylot", "neural": "Roach"}  # ours, and the paper's of that kind

SUMMARY: dict[str, dict[str, dict[str, float]]] = {
    "modular": {
        "random": {"fix": 16.5, "deg": 2.5, "delta_e": 14.0, "intensity": 1.20},
        "rule": {"fix": 42.0, "deg": 1.5, "delta_e": 40.5, "intensity": 0.91},
        "model": {"fix": 34.5, "deg": 4.5, "delta_e": 30.0, "intensity": 1.69},
        "rand_r": {"fix": 63.0, "deg": 6.5, "delta_e": 56.5, "intensity": 0.93},
        "only_sl": {"fix": 72.0, "deg": 0.0, "delta_e": 72.0, "intensity": 0.87},
        "only_rl": {"fix": 32.0, "deg": 3.5, "delta_e": 28.5, "intensity": 0.23},
        "wo_sr": {"fix": 75.5, "deg": 3.5, "delta_e": 72.0, "intensity": 1.02},
        "adreft": {"fix": 78.5, "deg": 2.5, "delta_e": 76.0, "intensity": 0.72},
    },
    "neural": {
        "random": {"fix": 27.0, "deg": 6.5, "delta_e": 20.5, "intensity": 0.78},
        "rule": {"fix": 58.0, "deg": 3.0, "delta_e": 55.0, "intensity": 1.11},
        "model": {"fix": 56.5, "deg": 7.5, "delta_e": 49.0, "intensity": 1.67},
        "rand_r": {"fix": 80.0, "deg": 16.5, "delta_e": 63.5, "intensity": 0.89},
        "only_sl": {"fix": 87.5, "deg": 12.0, "delta_e": 75.5, "intensity": 0.98},
        "only_rl": {"fix": 36.5, "deg": 6.0, "delta_e": 30.5, "intensity": 0.19},
        "wo_sr": {"fix": 87.0, "deg": 7.5, "delta_e": 79.5, "intensity": 0.83},
        "adreft": {"fix": 90.5, "deg": 5.5, "delta_e": 85.0, "intensity": 0.77},
    },
}

_FAMILY_ROWS: dict[str, dict[str, tuple[tuple[float, float, float], ...]]] = {  # fix, deg, intensity of S1 .. S5
    "modular": {
        "random": ((37.5, 0.0, 1.23), (12.5, 2.5, 1.23), (15.0, 0.0, 1.18), (5.0, 7.5, 1.16), (12.5, 2.5, 1.14)),
        "rule": ((5.0, 0.0, 0.39), (65.0, 0.0, 1.21), (50.0, 0.0, 0.72), (15.0, 7.5, 1.32), (75.0, 0.0, 0.89)),
        "model": ((60.0, 5.0, 1.77), (42.5, 2.5, 1.71), (42.5, 2.5, 1.71), (20.0, 10.0, 1.65), (7.5, 2.5, 1.61)),
        "adreft": ((72.5, 2.5, 0.71), (85.0, 0.0, 0.74), (60.0, 5.0, 0.63), (80.0, 5.0, 0.78), (95.0, 0.0, 0.74)),
    },
    "neural": {
        "random": ((45.0, 7.5, 0.83), (35.0, 5.0, 0.83), (40.0, 5.0, 0.81), (7.5, 12.5, 0.69), (7.5, 2.5, 0.73)),
        "rule": ((57.5, 0.0, 0.91), (82.5, 0.0, 1.39), (47.5, 5.0, 1.11), (62.5, 10.0, 1.35), (40.0, 0.0, 0.79)),
        "model": ((72.5, 5.0, 1.75), (70.0, 15.0, 1.79), (85.0, 2.5, 1.65), (27.5, 12.5, 1.55), (27.5, 2.5, 1.63)),
        "adreft": ((82.5, 12.5, 0.87), (97.5, 5.0, 0.93), (90.0, 2.5, 0.88), (85.0, 7.5, 0.61), (97.5, 0.0, 0.56)),
    },
}

FAMILIES: dict[str, dict[str, dict[str, dict[str, float]]]] = {
    f"S{number + 1}": {
        policy: {
            method: {
                "fix": row[number][0],
                "deg": row[number][1],
                "delta_e": row[number][0] - row[number][1],
                "intensity": row[number][2],
            }
            for method, row in methods.items()
        }
        for policy, methods in _FAMILY_ROWS.items()
    }
    for number in range(5)
}

MONITOR: dict[str, dict[str, dict[str, float]]] = {
    "modular": {
        "rule": {"precision": 74.42, "recall": 6.91, "f1": 12.64},
        "model": {"precision": 18.80, "recall": 26.75, "f1": 22.08},
        "wo_regulation": {"precision": 51.30, "recall": 79.96, "f1": 62.50},
        "adreft": {"precision": 51.90, "recall": 80.34, "f1": 63.06},
    },
    "neural": {
        "rule": {"precision": 52.78, "recall": 9.15, "f1": 15.60},
        "model": {"precision": 12.21, "recall": 10.71, "f1": 11.41},
        "wo_regulation": {"precision": 60.01, "recall": 68.68, "f1": 64.05},
        "adreft": {"precision": 55.43, "recall": 80.09, "f1": 65.52},
    },
}

COST: dict[str, dict[str, float]] = {
    "adreft": {"mean_ms": 3.421, "model_mb": 17.26},
    "rule": {"mean_ms": 0.718},
    "model": {"mean_ms": 1.119},
}

PAPER: dict[str, Any] = {
    "policies": POLICIES,
    "summary": SUMMARY,
    "families": FAMILIES,
    "monitor": MONITOR,
    "cost": COST,
}
