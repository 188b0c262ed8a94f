"""Stage II of SAFE: a crash report with one of its vehicles replaced by the policy under test, as a scenario."""

import random
import re
from dataclasses import dataclass

from roadmend.safe.casting import EDGE_OF_LIFE, MeetingStage
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.layout import lay_out
from roadmend.safe.open_questions import answer, open_questions
from roadmend.world import scenario as world
from roadmend.world.space import Parameters, sample


@dataclass(frozen=True, slots=True)
class CrashRole:
    """A report with one of its vehicles played by the policy under test."""

    report: str  # its name
    crash: CrashScenario
    ego: int  # index of that vehicle

    @property
    def number(self) -> int:
        """The report's number of the vehicle, from 1."""
        return self.ego + 1


def draw_scenario(role: CrashRole, index: int, seed: int = 0) -> world.Scenario:
    """Draw what a report leaves open; the same report, role, index and seed give the same scenario.

    Raises:
        InputError: no road network can be built for the report.
    """
    drawn = sample(open_questions(role.crash), generator_of(role, f"{seed}/{index}"))
    return build_scenario(role, drawn, f"{role.report}-v{role.number}-{index}", seed)


def generator_of(role: CrashRole, purpose: str) -> random.Random:
    """Random numbers that depend on the report, the role and the purpose alone."""
    return random.Random(f"roadmend/safe/{role.report}/{role.number}/{purpose}")


def build_scenario(role: CrashRole, drawn: Parameters, name: str, seed: int) -> world.Scenario:
    """The scenario that a point of the open questions stands for.

    Args:
        role: the report, and who is the ego in it.
        drawn: a point of :func:`roadmend.safe.open_questions.open_questions`.
        name: of the scenario; characters that a name may not have become '-'.
        seed: of the simulator.

    Raises:
        InputError: no road network can be built for the report.
    """
    crash = answer(role.crash, drawn)
    layout = lay_out(crash, drawn)
    weather = crash.environment.weather
    time = crash.environment.time
    assert weather is not None
    assert time is not None
    environment = world.Environment.model_validate({"weather": weather.lower(), "time_of_day": time.lower()})
    stage = MeetingStage(role.crash, role.ego, crash, layout, drawn, environment.effective_friction)
    return world.Scenario(
        name=re.sub(r"[^A-Za-z0-9_.\-]", "-", name),
        seed=seed,
        time_limit=EDGE_OF_LIFE,
        network=layout.network,
        ego=stage.ego(),
        actors=stage.actors(),
        environment=environment,
        origin=world.ReportOrigin(
            report=role.report, vehicle=role.number, sampled=dict(drawn), adapted=[*layout.adapted, *stage.adapted]
        ),
    )
