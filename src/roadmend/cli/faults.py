"""``roadmend faults``: what the graph does when something in it breaks, and commands when a file is broken."""

import json
import signal
import uuid
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import click

from roadmend.cli.call import call_again
from roadmend.cli.command import ExampleCommand
from roadmend.cli.options import JSON, RESULT_FOLDER, Number, settings_file
from roadmend.cli.output import counting, show_rows
from roadmend.core.journal import Entry, Journal, Key, entry_key
from roadmend.core.resources import config_folder
from roadmend.faults.campaign import FILES, RATE_MAX, RATE_MIN, FaultCampaign, FaultTrial, load_campaign, trials_of
from roadmend.faults.fault import MethodFault
from roadmend.faults.files import FileBench, FileTrial, Refused, file_trials
from roadmend.faults.processes import end_all
from roadmend.faults.refusal import file_table, refusal_rows
from roadmend.faults.staging import METHOD, model_digests
from roadmend.faults.trial import Disturbed, disturb
from roadmend.faults.verdict import Judged, campaign_rows, judge, table
from roadmend.measures.driver import driver_key
from roadmend.measures.fitting import fitting
from roadmend.nodes.domain import own_domain
from roadmend.nodes.loopback import reach
from roadmend.reports.result_files import provenance, write_report

TITLE = "Faults in the running graph, and damaged files"
_FORMAT = "roadmend-faults/2"
_MARK = "ROADMEND_CAMPAIGN"  # environment variable by which a call's processes are found
_CODE = tuple(f"roadmend.nodes.{name}" for name in ("launcher", "policy", "recorder", "relay", "repair", "sim", "viz"))
_CODE += ("roadmend.faults.trial", "roadmend.cli.run")
_FILE_CODE = tuple(
    f"roadmend.cli.{name}"
    for name in ("main", "bag", "corpus", "evaluate", "networks", "run", "safe", "search", "sera_bank")
)
_FILE_CODE += (*_CODE, "roadmend.faults.files")


@click.command(
    cls=ExampleCommand,
    examples=["roadmend faults --out disturbed", "roadmend faults --config mine.yaml --count 20 --out disturbed"],
    resumes="",
)
@settings_file("The campaign.  [default: config/faults/campaign.yaml]")
@click.option("--count", type=click.IntRange(1, 1000), help="Runs of every row.  [default: the campaign's]")
@click.option("--rate", "rates", type=Number(RATE_MIN, RATE_MAX), multiple=True, help="Of real time; may be repeated.")
@click.option(
    "--fault",
    "names",
    multiple=True,
    help=f"Rows of the campaign alone, {FILES!r} for those of files; may be repeated.  [default: all]",
)
@click.option(
    "--parallel",
    default=1,
    show_default=True,
    type=click.IntRange(1, 64),
    help="Runs at once. They share the processor: too many, and states are declared late in real time.",
)
@RESULT_FOLDER
@click.option("--page", "with_page", is_flag=True, help="Write faults.html as well: the tables, and every run.")
@JSON
def faults(
    file: Path | None,
    count: int | None,
    rates: tuple[float, ...],
    names: tuple[str, ...],
    parallel: int,
    out: Path,
    *,
    with_page: bool,
    as_json: bool,
) -> int:
    """Disturb the running graph and judge what comes of it; give damaged files to commands.

    Each run starts 'roadmend run' as anybody would, and disturbs it at a moment drawn by the seed: a signal to one of its
    nodes, messages that a relay distorts on their way, or a method that fails. Then it looks at the exit code, at what was
    said, at what was left behind, and into the bag. The exit code is 1 if a run was not safe, or a fault was not reported
    or came too late in every run of its row.
    """
    if with_page:  # before an hour of runs, not after them: it needs an extra
        from roadmend.reports.faults_page import write_page  # noqa: PLC0415
    campaign = _chosen(load_campaign(file or config_folder() / "faults" / "campaign.yaml"), names, count, rates)
    runs: list[tuple[FaultTrial, Disturbed]]
    refused: list[tuple[FileTrial, Refused]] = []
    keys, file_keys = _run_keys(campaign), _file_keys(campaign)
    with Journal(out / "runs.jsonl", _FORMAT, owns_folder=True) as journal, counting() as progress:
        missing = [trial for trial, key in keys.items() if journal.get(key) is None]
        task = progress.add_task("runs", total=len(keys), completed=len(keys) - len(missing))
        for trial, disturbed in _all_disturbed(campaign, missing, parallel):
            journal.add(keys[trial], disturbed.as_dict())
            progress.update(task, advance=1)
        runs = [(trial, Disturbed.parse(journal.get(key) or {})) for trial, key in keys.items()]
        task, bench = progress.add_task("files", total=len(file_keys)), FileBench()
        for one, key in file_keys.items():
            entry = _kept(journal, key, lambda: bench.give(one).as_dict())  # noqa: B023
            refused.append((one, Refused.parse(entry)))
            progress.update(task, advance=1)
    judged = judge(runs)
    rows, file_rows = campaign_rows(judged), refusal_rows(refused)
    content: dict[str, Any] = {
        "format": _FORMAT,
        "provenance": provenance(call_again()),
        "campaign": campaign.model_dump(mode="json"),
        "rows": [*rows, *file_rows],
        "too_late": sum(not disturbed.injected for _, disturbed in runs),
        "runs": [_told(trial, disturbed) for trial, disturbed in runs],
        "files": [one.as_dict() | each.as_dict() | {"stderr": None} for one, each in refused],
    }
    tables = table(rows), file_table(file_rows) if file_rows else []
    write_report(out, "faults", TITLE, content, *tables)
    if with_page:
        write_page(out, TITLE, tables, judged, file_rows, content["provenance"])
    if as_json:
        click.echo(json.dumps(content, indent=2))
    else:
        for each_table in filter(None, tables):
            show_rows(each_table)
    return 1 if _complain(judged, file_rows) else 0


def _told(trial: FaultTrial, disturbed: Disturbed) -> dict[str, Any]:
    """A run with its fault by name, which the campaign describes; what was said names temporary folders, and stays out."""
    name = {"fault": trial.fault.name if trial.fault else None}
    entry: dict[str, Any] = trial.as_dict() | disturbed.as_dict() | name
    del entry["stderr"]
    return entry


_SETTINGS = ("policy", "repair", "families", "first_scenario", "time_limit", "earliest", "latest", "patience")


def _chosen(
    campaign: FaultCampaign, names: tuple[str, ...], count: int | None, rates: tuple[float, ...]
) -> FaultCampaign:
    """The campaign as the options change it."""
    if names:
        known = [*(fault.name for fault in campaign.faults), *([FILES] if campaign.files else [])]
        for name in names:
            if name not in known:
                raise click.BadParameter(f"there is no {name!r}; choose of {', '.join(known)}", param_hint="--fault")
        campaign = campaign.only(names)
    if count is not None:
        campaign = campaign.model_copy(update={"seeds": count})
    return campaign.model_copy(update={"rates": rates}) if rates else campaign


def _run_keys(campaign: FaultCampaign) -> dict[FaultTrial, Key]:
    """The runs of the graph, each with what decides it."""
    if not campaign.faults:
        return {}
    settings = campaign.model_dump(mode="json", include={*_SETTINGS})
    driver = driver_key(campaign.policy, campaign.repair, fitting(campaign.repair, campaign.policy))
    spoilt = [driver_key(campaign.policy, METHOD), *model_digests()] if campaign.methods else []
    return {
        trial: entry_key(
            _CODE, driver, spoilt if isinstance(trial.fault, MethodFault) else [], settings, trial.as_dict()
        )
        for trial in trials_of(campaign)
    }


def _file_keys(campaign: FaultCampaign) -> dict[FileTrial, Key]:
    """The files, each with what decides what comes of it."""
    if campaign.files is None:
        return {}
    drivers = [driver_key("modular", "adreft"), driver_key("ego_mlp")]  # of the kinds' commands
    return {one: entry_key(_FILE_CODE, drivers, one.as_dict()) for one in file_trials(campaign.files)}


def _kept(journal: Journal, key: Any, make: Callable[[], Entry]) -> Entry:
    """An entry of the journal, made and kept if it is not there."""
    entry = journal.get(key)
    if entry is None:
        entry = make()
        journal.add(key, entry)
    return entry


def _all_disturbed(
    campaign: FaultCampaign, trials: Sequence[FaultTrial], parallel: int
) -> Iterator[tuple[FaultTrial, Disturbed]]:
    """Runs and what came of them, in the order in which they end; those under way are ended with the caller."""
    token = uuid.uuid4().hex  # in the environment of all that this call starts
    with _interrupted_by_termination(), ThreadPoolExecutor(parallel) as pool:
        tasks = {pool.submit(_disturbed, campaign, trial, token): trial for trial in trials}
        try:
            for task in as_completed(tasks):
                yield tasks[task], task.result()
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            end_all(f"{_MARK}={token}")
            raise


@contextmanager
def _interrupted_by_termination() -> Iterator[None]:
    """While this lasts, SIGTERM is an interrupt: by itself it would leave the graphs under way to their end."""
    previous = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)


def _disturbed(campaign: FaultCampaign, trial: FaultTrial, token: str) -> Disturbed:
    with own_domain(is_chosen=False) as domain:  # one for each of those at once
        return disturb(campaign, trial, {"ROS_DOMAIN_ID": str(domain), **reach(), _MARK: token})


def _complain(judged: list[Judged], file_rows: list[dict[str, Any]]) -> bool:
    """Say what is not as it should be; whether anything is not.

    A run whose fault came too late is not wrong, but a row that has no other shows nothing.
    """
    rows = Counter(_row_of(each) for each in judged)
    late = Counter(_row_of(each) for each in judged if not each.disturbed.injected)
    for where, count in late.items():
        click.echo(f"{where}: the fault came too late in {count} of {rows[where]} runs", err=True)
    wrong = [each for each in judged if each.faults or not each.is_reported]
    for each in wrong:
        why = ", ".join([*each.faults, *([] if each.is_reported else ["not reported"])])
        click.echo(f"{_row_of(each)}, seed {each.trial.seed}: {why}", err=True)
    broken = [row for row in file_rows if row["faults"]]
    for row in broken:
        click.echo(f"{row['fault']}: {', '.join(row['faults'])}", err=True)
    return bool(wrong or broken or any(count == rows[where] for where, count in late.items()))


def _row_of(each: Judged) -> str:
    return f"{each.trial.row}, {each.trial.clock} x {each.trial.rate:g}"
