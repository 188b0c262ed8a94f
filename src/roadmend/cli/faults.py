"""``roadmend faults``: what the graph does when something in it breaks."""

import json
from pathlib import Path
from typing import Any

import click

from roadmend.cli.command import ExampleCommand
from roadmend.cli.options import JSON, RESULT_FOLDER, settings_file
from roadmend.cli.output import counting, show_rows
from roadmend.core.journal import Journal, entry_key
from roadmend.core.resources import config_folder
from roadmend.faults.campaign import FaultTrial, load_campaign, trials_of
from roadmend.faults.trial import Disturbed, disturb
from roadmend.faults.verdict import campaign_rows, judge, table
from roadmend.reports.result_files import provenance, write_report

_FORMAT = "roadmend-faults/1"
_CODE = ("roadmend.faults.trial", "roadmend.nodes.launcher", "roadmend.nodes.repair", "roadmend.nodes.sim")


@click.command(
    cls=ExampleCommand,
    examples=["roadmend faults --out disturbed", "roadmend faults --config mine.yaml --count 20 --out disturbed"],
    resumes="",
)
@settings_file("The campaign.  [default: config/faults/campaign.yaml]")
@click.option("--count", type=click.IntRange(1, 1000), help="Runs of every row.  [default: the campaign's]")
@click.option("--fault", "names", multiple=True, help="Rows of the campaign alone; may be repeated.  [default: all]")
@RESULT_FOLDER
@JSON
def faults(file: Path | None, count: int | None, names: tuple[str, ...], out: Path, *, as_json: bool) -> int:
    """Disturb the running graph and judge what comes of it.

    Each run starts 'roadmend run' as anybody would, sends a signal to one of its nodes at a moment drawn by the seed, and
    then looks at the exit code, at what was said, at what was left behind, and into the bag. The exit code is 1 if a run
    was not safe or a fault was not reported.
    """
    campaign = load_campaign(file or config_folder() / "faults" / "campaign.yaml")
    if names:
        known = [fault.name for fault in campaign.faults]
        for name in names:
            if name not in known:
                raise click.BadParameter(f"there is no {name!r}; choose of {', '.join(known)}", param_hint="--fault")
        campaign = campaign.model_copy(update={"faults": tuple(f for f in campaign.faults if f.name in names)})
    if count is not None:
        campaign = campaign.model_copy(update={"seeds": count})
    trials = list(trials_of(campaign))
    settings = campaign.model_dump(mode="json", exclude={"faults", "seeds", "clocks", "rates"})
    runs: list[tuple[FaultTrial, Disturbed]] = []
    with Journal(out / "runs.jsonl", _FORMAT, owns_folder=True) as journal, counting() as progress:
        task = progress.add_task("runs", total=len(trials))
        for trial in trials:
            key = entry_key(_CODE, settings, trial.as_dict())
            kept = journal.get(key)
            disturbed = Disturbed.parse(kept) if kept is not None else disturb(campaign, trial)
            if kept is None:
                journal.add(key, disturbed.as_dict())
            runs.append((trial, disturbed))
            progress.update(task, advance=1)
    judged = judge(runs)
    rows = campaign_rows(judged)
    content: dict[str, Any] = {
        "format": _FORMAT,
        "provenance": provenance("./roadmend faults" + (f" --count {count}" if count else "")),
        "campaign": campaign.model_dump(mode="json"),
        "rows": rows,
        "too_late": sum(not disturbed.injected for _, disturbed in runs),
        # What was said names temporary folders; it stays in runs.jsonl.
        "runs": [trial.as_dict() | disturbed.as_dict() | {"stderr": None} for trial, disturbed in runs],
    }
    write_report(out, "faults", "Faults in the running graph", content, table(rows))
    if as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        show_rows(table(rows))
    wrong = [each for each in judged if each.faults or not each.is_reported]
    for each in wrong:
        why = ", ".join([*each.faults, *([] if each.is_reported else ["not reported"])])
        click.echo(
            f"{each.trial.row}, {each.trial.clock} x {each.trial.rate:g}, seed {each.trial.seed}: {why}", err=True
        )
    return 1 if wrong else 0
