"""Kept rows of methods with a model: whether it is today's, so that none is taken for what stands beside it."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from harness.contenders import BenchmarkPlan, resolve

Content = dict[str, Any]
MARK = "kept_model"  # of a row: "earlier", or "unknown" where the row does not tell


def mark_models(content: Content, plan: BenchmarkPlan, config: Path) -> None:
    """Mark the rows of ordinary drives, prices and controls that are of an earlier or of an unknown model.

    Raises:
        InputError: a parameter of a method is unusable.
    """
    rows = [*_rows(content)]
    names: dict[str, list[str]] = {}
    for policy, method, _ in rows:
        names.setdefault(policy, []).append(method)
    today = {
        policy: {
            contender.name: contender.describe()
            for contender in resolve(plan, config, policy, [name for name in plan.methods if name in methods])[0]
        }
        for policy, methods in names.items()
    }
    for policy, method, row in rows:
        row.pop(MARK, None)
        now = today[policy].get(method)
        if "contender" not in row:
            if now is None or "model" in now:
                row[MARK] = "unknown"
        elif _digest(row["contender"]) != _digest(now or {}):
            row[MARK] = "earlier"


def row_title(titles: Mapping[str, str], method: str, row: Mapping[str, Any] | None) -> str:
    """What a method is called in a row, which tells if it is of another model than today's."""
    title = titles.get(method, method)
    return title if row is None or MARK not in row else f"{title} ({row[MARK]} model)"


def _digest(contender: Mapping[str, Any]) -> str:
    return str(contender.get("model", {}).get("digest", ""))


def _rows(content: Content) -> Iterator[tuple[str, str, Content]]:
    """Policy, method and figures of every row that has a method."""
    for policies in content.get("ordinary", {}).values():
        for policy, methods in policies.items():
            for method, row in methods.items():
                yield policy, method, row
    for policy, methods in content.get("at_time_lost", {}).items():
        for method, prices in methods.items():
            for point in prices.values():
                if point is not None:
                    yield policy, method, point
    for policy, found in content.get("controls", {}).items():
        for method, row in found["shuffled"].items():
            yield policy, method, row
