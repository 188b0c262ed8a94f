"""Everything slow that the benchmark of SERA does, each kept by what decided it, so that nothing is done twice."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from roadmend.core.fanout import Mapper
from roadmend.core.journal import Journal, Key, entry_key, file_of
from roadmend.measures.driving import DrivingMeasures
from roadmend.networks.checkpoint import load_checkpoint
from roadmend.policies.neural import load_model
from roadmend.repair.adreft.model import KIND
from roadmend.training.demonstrations import Lesson, gather
from roadmend.training.few_shot import Labour, drive_once, few_shot_repair
from roadmend.training.few_shot_settings import FewShotSettings, repair_model
from roadmend.training.samples import Samples, load_samples, save_samples
from roadmend.world.scenario import Scenario

_CODE = ("roadmend.policies.neural", "roadmend.measures.measured_run", "roadmend.repair.registry")
_REPAIR = "roadmend.repair.adreft.method"


@dataclass
class KeptRuns:
    """Drives, gathers and tunes in a folder."""

    journal: Journal
    mapper: Mapper
    report: Callable[[str], None] = field(default=lambda _what: None)  # hears of everything that is newly done

    @property
    def folder(self) -> Path:
        """For what is no JSON."""
        return self.journal.path.parent

    def drive(self, model: Path, scenarios: Sequence[Scenario]) -> list[DrivingMeasures]:
        """The measures of a policy in scenarios, in order."""
        digest = load_model(model).digest
        keys = [entry_key(_CODE, "drive", digest, scenario.digest) for scenario in scenarios]
        tasks = {key: (model, one) for key, one in zip(keys, scenarios, strict=True) if self.journal.get(key) is None}
        for key, measures in zip(tasks, self.mapper(drive_once, tasks.values()), strict=True):
            self.journal.add(key, asdict(measures))
            self.report("driven")
        return [DrivingMeasures.parse(self._get(key)) for key in keys]

    def gather(self, lessons: Sequence[Lesson]) -> Iterator[Samples]:
        """The samples of lessons, in order."""
        digests = {path: load_model(path).digest for path in {lesson.model for lesson in lessons} if path is not None}
        repairs = {path: _repair_digest(path) for path in {lesson.repair for lesson in lessons} if path is not None}
        places = {}
        for lesson in lessons:
            key = entry_key(
                [*_CODE, gather.__module__, *([] if lesson.repair is None else [_REPAIR])],
                "gather",
                lesson.scenario.digest,
                lesson.draw,
                None if lesson.model is None else digests[lesson.model],
                lesson.expert_share,
                lesson.noise,
                lesson.every,
                None if lesson.repair is None else repairs[lesson.repair],
            )
            places[key] = file_of(self.folder / "lessons", key, ".npz"), lesson
        missing = {key: lesson for key, (path, lesson) in places.items() if not path.exists()}
        for key, samples in zip(missing, self.mapper(gather, missing.values()), strict=True):
            save_samples(places[key][0], samples, key)
            self.report("demonstrated")
        return (load_samples(path, key) for key, (path, _) in places.items())

    def tune(
        self,
        model: Path,
        scenarios: Sequence[Scenario],
        settings: FewShotSettings,
        seed: int,
        validation: Sequence[Scenario],
    ) -> Path:
        """The model that few-shot repair makes; its trials are in its header."""
        repair = repair_model(settings)
        key = entry_key(
            [*_CODE, few_shot_repair.__module__, *([] if repair is None else [_REPAIR])],
            "tune",
            load_model(model).digest,
            settings.model_dump(mode="json"),
            seed,
            [scenario.digest for scenario in scenarios],
            [scenario.digest for scenario in validation],
            None if repair is None else _repair_digest(repair),
        )
        path = file_of(self.folder / "models", key, ".safetensors")
        if not path.exists():
            few_shot_repair(
                model,
                scenarios,
                settings,
                seed,
                path,
                validation=validation,
                labour=Labour(gathering=self.gather, driving=lambda tuned, chosen: iter(self.drive(tuned, chosen))),
            )
            self.report("tuned")
        return path

    def remember(self, what: str, key: Key, make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """What ``make`` gives, made once for all that decides it."""
        kept = self.journal.get(key)
        if kept is None:
            kept = make()
            self.journal.add(key, kept)
            self.report(what)
        return kept

    def _get(self, key: Key) -> dict[str, Any]:
        found = self.journal.get(key)
        assert found is not None
        return found


def kept_epochs(model: Path) -> int:
    """How many epochs the guard kept of a tuned model."""
    return int(load_checkpoint(model).header["metrics"]["kept"]["epochs"])


def _repair_digest(path: Path) -> str:
    """Of ADReFT's model: its name alone does not tell one training from the next."""
    return load_checkpoint(path, KIND).digest
