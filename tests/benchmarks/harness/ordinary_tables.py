"""Tables of ordinary driving and of what methods fix at a price."""

from collections.abc import Mapping
from typing import Any

from harness.kept_models import row_title
from harness.table import Table, number, span

Content = Mapping[str, Any]


def ordinary_tables(content: Content) -> list[Table]:
    """All that there is something to say in."""
    tables = [_ordinary(content, name) for name in content["ordinary"]]
    return [*tables, _at_time_lost(content)] if content["at_time_lost"] else tables


def _ordinary(content: Content, name: str) -> Table:
    rows: list[tuple[str, ...]] = [
        (
            "policy",
            "method",
            "drives",
            "untouched [%]",
            "time lost [%]",
            "median [%]",
            "distance lost [%]",
            "needless [s/h]",
            "needed [%]",
            "spells [1/km]",
            "jerk [m/s³]",
            "collisions alone",
            "collisions",
            "new",
            "cut short",
            "whosever fault: alone",
            "with repair",
        )
    ]
    for policy, methods in content["ordinary"][name].items():
        for method, figures in methods.items():
            rows.append(
                (
                    policy,
                    row_title(content["titles"], method, figures),
                    str(figures["drives"]),
                    number(figures["untouched"]),
                    number(figures["time_lost"], 2),
                    number(figures["time_lost_median"], 2),
                    number(figures["distance_lost"], 2),
                    number(figures["needless_dose_per_hour"], 2),
                    number(figures.get("spells_needed")),
                    number(figures["spells_per_km"], 2),
                    number(figures["mean_jerk"], 2),
                    str(figures["collisions_bare"]),
                    str(figures["collisions"]),
                    str(figures["new_collisions"]),
                    *(number(figures.get(key), 0) for key in ("cut_short", "struck_bare", "struck")),
                )
            )
    note = (
        "Drives in which the policy alone does not collide by its own fault. Untouched: no lane change is held back, and changed by less than 0.2 s of "
        "full command. Time lost: mean and median over those that the policy alone brings to the goal; distance lost: "
        "over those that the time limit ends. Needless: dose in interventions of which fewer than one future in ten "
        "violates; needed: interventions, those of all drives, of which at least one in five does; a dash where that was "
        "not looked at. Collisions by the ego's own fault, of all drives; new: where the policy alone has none. Cut short: drives "
        "that alone go on to the goal or the time limit and with repair end before, in nobody's loss of time. Whosever "
        "fault: all collisions, those of a standing ego that others drive into among them; a dash where a row is of a "
        "run that did not count them."
    )
    return Table(f"Ordinary driving: {name}", note, tuple(rows))


def _at_time_lost(content: Content) -> Table:
    rows: list[tuple[str, ...]] = [
        (
            "policy",
            "method",
            "price [%]",
            "setting",
            "ΔE",
            "95 %",
            "ADReFT more",
            "95 %",
            "time lost [%]",
            "untouched [%]",
            "dose [s]",
            "new",
        )
    ]
    for policy, methods in content["at_time_lost"].items():
        for method, prices in methods.items():
            for price, point in prices.items():
                if point is None:
                    rows.append((policy, content["titles"].get(method, method), price, *[number(None)] * 9))
                    continue
                varied = ", ".join(f"{name} {value}" for name, value in point["parameters"].items())
                rows.append(
                    (
                        policy,
                        row_title(content["titles"], method, point),
                        price,
                        varied,
                        number(point["delta_e"]),
                        span(point["interval"]),
                        *_more(method, point["lead"]),
                        number(point["time_lost"], 2),
                        number(point["untouched"]),
                        number(point["dose"], 2),
                        str(point["new_collisions"]),
                    )
                )
    note = (
        "The setting of the greatest ΔE among those that lose no more than the price, chosen on validation cases and "
        "random drives of their own; the figures are of the test cases and of the random drives of the table above. "
        "The interval of ΔE draws searches. ADReFT more: its ΔE at the same price less the method's, with the paired "
        "bootstrap's interval over searches."
    )
    return Table("What is fixed at a given loss of time", note, tuple(rows))


def _more(method: str, lead: Mapping[str, Any] | None) -> tuple[str, str]:
    if lead is None or method == "adreft":
        return number(None), number(None)
    return number(lead["delta_e"]), span(lead["interval"])
