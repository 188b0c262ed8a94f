"""Interventions for people and for programs: what they did, what they were worth, because of whom, why, and if needed."""

import math
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from roadmend.core.spell_account import SpellAccount
from roadmend.measures.need_verdict import NeedVerdict, verdict_of

_STYLES = {NeedVerdict.RESCUE: "green", NeedVerdict.UNCLEAR: "yellow", NeedVerdict.NUISANCE: "red"}


def account_figures(account: SpellAccount) -> dict[str, Any]:
    """Plain values, for JSON, with the verdict; None where nobody has looked at the need."""
    return account.as_dict() | {"verdict": verdict_of(account.spell.need)}


def show_spells(accounts: Sequence[SpellAccount], console: Console) -> None:
    """Print a table, a row an intervention. A verdict stands there only where the need of any is known."""
    table = Table(box=None, pad_edge=False, header_style="bold")
    is_looked_at = any(account.spell.need is not None for account in accounts)
    for title in ("begins", "lasts", "dose", "strongest", "worth", *(("need",) if is_looked_at else ())):
        table.add_column(title, justify="right", no_wrap=True)
    for title in (*(("verdict",) if is_looked_at else ()), "who", "why"):
        table.add_column(title, no_wrap=title == "verdict")
    for account in accounts:
        table.add_row(*_row(account, with_need=is_looked_at))
    console.print(table)


def _row(account: SpellAccount, *, with_need: bool) -> list[str]:
    spell, verdict = account.spell, verdict_of(account.spell.need)
    told = [] if spell.need is None or verdict is None else [f"{spell.need:.2f}", f"[{_STYLES[verdict]}]{verdict}[/]"]
    return [
        f"{spell.begin:.2f} s",
        f"{spell.end - spell.begin:.2f} s",
        f"{spell.dose:.2f} s",
        f"{account.strongest:+.2f}",
        "-" if account.worth is None or math.isnan(account.worth) else f"{account.worth:+.2f}",
        *((told or ["-", "-"]) if with_need else ()),
        escape("; ".join(sight.words for sight in account.chiefly)) or "-",
        escape(account.why) or "-",
    ]
