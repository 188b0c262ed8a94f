"""``roadmend bench liar``: what becomes of one false field in a language model's answers, and of honest answers."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import click

from harness.crash_oracles import KnownReport, reports_in, sample_reports
from harness.figures import Figures
from harness.liar import APART, INVENTED, LEFT_OUT, META_ALONE, AnsweringModel, Lie, lies, meta_of
from roadmend.reports.result_files import provenance
from roadmend.safe.answer_check import ALONE, TRUST
from roadmend.safe.dsl_data import dump_data
from roadmend.safe.embedded import EmbeddedExtractor
from roadmend.safe.extraction import Extraction, ExtractionError, Watch, unwatched
from roadmend.safe.reading_alignment import COLLISIONS, VEHICLES, agree, flat
from roadmend.safe.report import CrashReport
from roadmend.safe.stage_one import LanguageExtractor, StageOneOptions

FULL = "cross-check"
_ALWAYS = "objects to everything"


class _ReadOnce:
    """The embedded reader, which reads each report once; or one that reads nothing."""

    def __init__(self, *, reads: bool) -> None:
        self.reads = reads
        self.known: dict[str, Extraction | ExtractionError] = {}

    def extract(self, report: CrashReport, watch: Watch = unwatched) -> Extraction:
        if not self.reads:
            raise ExtractionError("not asked")
        if report.digest() not in self.known:
            try:
                self.known[report.digest()] = EmbeddedExtractor().extract(report, watch)
            except ExtractionError as error:
                self.known[report.digest()] = error
        found = self.known[report.digest()]
        if isinstance(found, ExtractionError):
            raise found
        return found


@dataclass
class Tally:
    """What became of lies and of honest answers under one way to check."""

    planted: Counter[str] = field(default_factory=Counter)  # by kind
    caught: Counter[str] = field(default_factory=Counter)
    told_apart: int = 0  # of the caught ones, where the same field of the honest answer is not in doubt
    told: int = 0  # inventions that are in dispute or said to rest on the model alone
    mended: int = 0  # lies in whose place the truth was kept
    fields: int = 0  # of honest answers
    alarms: int = 0  # of them disputed
    spoiled: int = 0  # of them replaced by something false
    reports: int = 0
    asked_again: int = 0  # of them about honest answers

    def rate(self) -> float | None:
        """Share of caught lies [%], but for the kinds that are counted by themselves."""
        planted = sum(count for kind, count in self.planted.items() if kind not in APART)
        caught = sum(count for kind, count in self.caught.items() if kind not in APART)
        return 100.0 * caught / planted if planted else None

    def as_dict(self) -> dict[str, Any]:
        """What JSON can hold."""
        return {
            "planted": sum(count for kind, count in self.planted.items() if kind not in APART),
            "caught": sum(count for kind, count in self.caught.items() if kind not in APART),
            "told_apart": self.told_apart,
            "caught_rate": self.rate(),
            "left_out": self.planted[LEFT_OUT],
            "left_out_caught": self.caught[LEFT_OUT],
            "invented": self.planted[INVENTED],
            "invented_caught": self.caught[INVENTED],
            "invented_told": self.told,
            "mended": self.mended,
            "by_kind": {kind: [self.caught[kind], self.planted[kind]] for kind in sorted(self.planted)},
            "honest_fields": self.fields,
            "false_alarms": self.alarms,
            "false_alarm_rate": 100.0 * self.alarms / self.fields if self.fields else None,
            "spoiled": self.spoiled,
            "honest_reports": self.reports,
            "honest_reports_asked_again": self.asked_again,
        }


def measure(known: Sequence[KnownReport], *, cross_check: bool, reads: bool, seed: int) -> Tally:
    """Ask a liar and an honest model about reports.

    Args:
        known: the reports and the truth about them.
        cross_check: hold answers against what is known without the model.
        reads: the embedded reader is among that.
        seed: decides the lies.
    """
    tally, reader = Tally(), _ReadOnce(reads=reads)

    def extract(report: CrashReport, scenario: Mapping[str, Any], meta: Mapping[str, Any]) -> Extraction | None:
        extractor = LanguageExtractor(AnsweringModel(scenario, meta), StageOneOptions(cross_check=cross_check), reader)
        try:
            return extractor.extract(report)
        except ExtractionError:
            return None  # given up, which is not kept in silence

    for each in known:
        honest = extract(each.report, dump_data(each.truth), meta_of(dump_data(each.truth)))
        _count_honest(tally, each, honest)
        in_doubt = _doubted(honest) if honest is not None else None
        for lie in lies(each.truth, each.others, f"{seed} {each.report.case}"):
            tally.planted[lie.kind] += 1
            found = extract(each.report, lie.scenario, lie.meta)
            if found is None or _is_caught(lie, found, each):
                tally.caught[lie.kind] += 1
                tally.told_apart += lie.kind not in APART and in_doubt is not None and not in_doubt & _places(lie.field)
            if lie.kind == INVENTED:
                tally.told += found is None or _is_caught(lie, found, each) or _is_alone(lie.field, found)
            if found is not None and lie.where != META_ALONE:
                tally.mended += _is_right(lie.field, flat(found.scenario), each)
    return tally


def _is_right(name: str, values: Mapping[str, Any], each: KnownReport) -> bool:
    truth = flat(each.truth)
    if name not in truth:  # a whole contact
        return all(values.get(part) == value for part, value in truth.items() if part.startswith(name))
    value = values.get(name)
    return any(agree(name, value, right) for right in (truth[name], *each.others.get(name, ())))


def _is_caught(lie: Lie, found: Extraction, each: KnownReport) -> bool:
    """Whether the result says that the field is in doubt, or holds the truth although the model stood by the lie."""
    if _doubted(found) & _places(lie.field):
        return True
    return lie.where != META_ALONE and _is_right(lie.field, flat(found.scenario), each)


def _is_alone(name: str, found: Extraction) -> bool:
    confidence = found.evidence[name].confidence
    return confidence is not None and confidence <= TRUST[ALONE]


def _doubted(found: Extraction) -> set[str]:
    """Disputed fields, and the contacts that they are of."""
    names = {name for name, evidence in found.evidence.items() if evidence.disputed}
    return names | {name.split(".")[0] for name in names if name.startswith(COLLISIONS)}


def _places(lied: str) -> set[str]:
    """Where a lie about a field may come to light."""
    if lied == VEHICLES:
        return {VEHICLES, COLLISIONS}
    return {lied.split(".", maxsplit=1)[0], COLLISIONS} if lied.startswith(COLLISIONS) else {lied}


def _count_honest(tally: Tally, each: KnownReport, found: Extraction | None) -> None:
    tally.reports += 1
    if found is None:
        tally.asked_again += 1
        return
    answered = {name: value for name, value in flat(each.truth).items() if _is_known(name, each)}
    alarms = [name for name, evidence in found.evidence.items() if evidence.disputed and _is_known(name, each)]
    tally.fields += len(answered)
    tally.alarms += len(alarms)
    values = flat(found.scenario)
    tally.spoiled += sum(not _is_right(name, values, each) for name in answered)
    asked = Counter(exchange.request["purpose"] for exchange in found.exchanges)
    tally.asked_again += bool(alarms) and (asked["meta_message"] > 1 or asked["scenario"] > 1)


def _is_known(name: str, each: KnownReport) -> bool:
    return name.split(".", maxsplit=1)[0].split("[", maxsplit=1)[0] in each.knows


def always_objecting(known: Sequence[KnownReport], seed: int) -> Tally:
    """What a check comes to that disputes every field of every answer."""
    tally = Tally()
    for each in known:
        planted = lies(each.truth, each.others, f"{seed} {each.report.case}")
        tally.planted.update(lie.kind for lie in planted)
        tally.caught.update(lie.kind for lie in planted)
        tally.told += sum(lie.kind == INVENTED for lie in planted)
        fields = sum(_is_known(name, each) for name in flat(each.truth))
        tally.fields += fields
        tally.alarms += fields
        tally.reports += 1
        tally.asked_again += 1
    return tally


@click.command()
@click.argument("folders", nargs=-1, type=click.Path(path_type=Path, exists=True, file_okay=False))
@click.option("--names", default="*", show_default=True, help="Pattern of the names of those in FOLDERS.")
@click.option("--seed", default=0, show_default=True, type=click.IntRange(0, 2**31 - 1), help="Of the lies.")
@click.option("--out", type=click.Path(path_type=Path, file_okay=False), help="Folder for liar.json and liar.md.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON.")
def liar(folders: tuple[Path, ...], names: str, seed: int, out: Path | None, *, as_json: bool) -> None:
    """Plant one false field at a time in right answers, and see whether the cross-check catches it.

    The reports are those of config/reports, and texts with an oracle beside them from FOLDERS. The model stays by its lie
    and passes itself whenever it is asked for a validation.
    """
    known = [*sample_reports(), *(each for folder in folders for each in reports_in(folder, names))]
    tallies = {
        "validation by the model alone": measure(known, cross_check=False, reads=False, seed=seed),
        "cross-check without the reader": measure(known, cross_check=True, reads=False, seed=seed),
        FULL: measure(known, cross_check=True, reads=True, seed=seed),
        _ALWAYS: always_objecting(known, seed),
    }
    given = [str(folder) for folder in folders] + (["--names", f"'{names}'"] if names != "*" else [])
    content = {
        "provenance": provenance(" ".join(["./roadmend bench liar", *given, f"--seed {seed}"])),
        "reports": len(known),
        "checks": {name: tally.as_dict() for name, tally in tallies.items()},
    }
    Figures("liar", "One false field in a model's answers", content, _rows(tallies)).publish(out, as_json=as_json)


def _rows(tallies: Mapping[str, Tally]) -> list[list[str]]:
    rows = [["what", *tallies]]

    def add(title: str, cell: Callable[[Tally], str]) -> None:
        rows.append([title, *map(cell, tallies.values())])

    add("false fields planted", lambda each: str(each.as_dict()["planted"]))
    add("caught", lambda each: _percent(each.as_dict()["caught_rate"]))
    add("told apart from the honest answer", lambda each: _share(each.told_apart, each.as_dict()["planted"]))
    for kind in sorted(kind for kind in tallies[FULL].planted if kind not in APART):
        add(f"caught: {kind}", lambda each, kind=kind: f"{each.caught[kind]} of {each.planted[kind]}")  # type: ignore[misc]
    add(
        "caught: fields left out that the report states",
        lambda each: f"{each.caught[LEFT_OUT]} of {each.planted[LEFT_OUT]}",
    )
    add(
        "invented where the report says nothing: caught",
        lambda each: f"{each.caught[INVENTED]} of {each.planted[INVENTED]}",
    )
    add("invented: caught, or said to be the model's alone", lambda each: f"{each.told} of {each.planted[INVENTED]}")
    add("honest answers: fields in dispute", lambda each: _share(each.alarms, each.fields))
    add("honest answers: fields replaced by something false", lambda each: _share(each.spoiled, each.fields))
    add("honest answers: reports asked about again", lambda each: _share(each.asked_again, each.reports))
    return rows


def _share(part: int, whole: int) -> str:
    return f"{_percent(100.0 * part / whole if whole else None)} ({part} of {whole})"


def _percent(share: float | None) -> str:
    return "-" if share is None else f"{share:.1f} %"
