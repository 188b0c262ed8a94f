"""Everything slow that the benchmark of SERA does, each kept by what decided it, so that nothing is done twice."""

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from roadmend.core.source_digest import source_digest
from roadmend.measures.driving import DrivingMeasures
from roadmend.measures.result_store import ResultStore
from roadmend.networks.checkpoint import load_checkpoint
from roadmend.policies.neural import load_model
from roadmend.repair.adreft.model import KIND
from roadmend.training.few_shot import drive_once, few_shot_repair, repair_model
from roadmend.training.few_shot_settings import FewShotSettings
from roadmend.training.imitation_rollout import Lesson, gather
from roadmend.training.samples import Samples, load_samples, save_samples
from roadmend.training.workers import Mapper
from roadmend.world.scenario import Scenario

_CODE = ("roadmend.policies.neural", "roadmend.measures.measured_run")


@dataclass
class Workshop:
    """Drives, gathers and tunes in a folder."""

    store: ResultStore
    mapper: Mapper
    report: Callable[[str], None] = field(default=lambda _what: None)  # hears of everything that is newly done

    def drive(self, model: Path, scenarios: Sequence[Scenario]) -> list[DrivingMeasures]:
        """The measures of a policy in scenarios, in order."""
        digest, code = load_model(model).digest, source_digest(_CODE)
        keys = [_key("drive", digest, code, scenario.digest) for scenario in scenarios]
        tasks = {key: (model, one) for key, one in zip(keys, scenarios, strict=True) if self.store.get(key) is None}
        for key, measures in zip(tasks, self.mapper(drive_once, tasks.values()), strict=True):
            self.store.add(key, asdict(measures))
            self.report("driven")
        return [DrivingMeasures.parse(self._get(key)) for key in keys]

    def gather(self, lessons: Sequence[Lesson]) -> Iterator[Samples]:
        """The samples of lessons, in order."""
        code = source_digest([*_CODE, "roadmend.training.imitation_rollout"])
        folder = self.store.folder / "lessons"
        folder.mkdir(exist_ok=True)
        places = {}
        digests = {path: load_model(path).digest for path in {lesson.model for lesson in lessons} if path is not None}
        repairs = {path: _repair_digest(path) for path in {lesson.repair for lesson in lessons} if path is not None}
        for lesson in lessons:
            driver = "" if lesson.model is None else digests[lesson.model]
            made_by = [
                code,
                lesson.scenario.digest,
                lesson.draw,
                driver,
                lesson.expert_share,
                lesson.noise,
                lesson.every,
            ]
            if lesson.repair is not None:
                made_by.append(repairs[lesson.repair])
            key = _key("gather", *made_by)
            places[key] = folder / f"{key[:32]}.npz", lesson
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
        code = source_digest([*_CODE, "roadmend.training.few_shot"])
        repair = repair_model(settings)
        key = _key(
            "tune",
            code,
            load_model(model).digest,
            settings.model_dump(mode="json"),
            seed,
            [scenario.digest for scenario in scenarios],
            [scenario.digest for scenario in validation],
            None if repair is None else _repair_digest(repair),
        )
        path = self.store.folder / "models" / f"{key[:32]}.safetensors"
        if not path.exists():
            few_shot_repair(
                model,
                scenarios,
                settings,
                seed,
                path,
                validation=validation,
                gathering=self.gather,
                driving=lambda tuned, chosen: iter(self.drive(tuned, chosen)),
            )
            self.report("tuned")
        return path

    def remember(self, what: str, content: Sequence[Any], make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
        """What ``make`` gives, made once for the content that decides it."""
        key = _key(what, *content)
        kept = self.store.get(key)
        if kept is None:
            kept = make()
            self.store.add(key, kept)
            self.report(what)
        return kept

    def _get(self, key: str) -> dict[str, Any]:
        found = self.store.get(key)
        assert found is not None
        return found


def kept_epochs(model: Path) -> int:
    """How many epochs the guard kept of a tuned model."""
    return int(load_checkpoint(model).header["metrics"]["kept"]["epochs"])


def _repair_digest(path: Path) -> str:
    """Of ADReFT's model: its name alone does not tell one training from the next."""
    return load_checkpoint(path, KIND).digest


def _key(*content: Any) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()
