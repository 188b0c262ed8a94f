"""Stage II of SAFE: a crash report with one of its vehicles replaced by the policy under test, as a scenario."""

import random
import re
from dataclasses import dataclass

from roadmend.safe.casting import EDGE_OF_LIFE, MeetingStage
from roadmend.safe.dsl import CrashScenario
from roadmend.safe.layout import lay_out
from roadmend.safe.onlooking import OnlookerStage
from roadmend.safe.open_questions import answer, open_questions
from roadmend.safe.staging import is_alone
from roadmend.world import scenario as world
from roadmend.world.space import Parameters, sample


@dataclass(frozen=True, slots=True)
class CrashRole:
    """A report with the policy under test in one role: one of its vehicles, or one who looks on.

    Attributes:
        report: its name.
        crash: what it says.
        ego: index of the vehicle whose place the policy takes; None where it looks on.
    """

    report: str
    crash: CrashScenario
    ego: int | None

    @property
    def number(self) -> int | None:
        """The report's number of the vehicle, from 1; None for an onlooker."""
        return None if self.ego is None else self.ego + 1

    @property
    def name(self) -> str:
        """As files are called by: "v1", "onlooker"."""
        return role_name(self.number)


def role_name(number: int | None) -> str:
    """The role of the vehicle with a number of the report; None is an onlooker."""
    return "onlooker" if number is None else f"v{number}"


def roles_of(report: str, crash: CrashScenario) -> list[CrashRole]:
    """The roles of a report in turn: all its vehicles, but an onlooker where one vehicle crashes alone."""
    egos = [None] if is_alone(crash) else [*range(len(crash.vehicles))]
    return [CrashRole(report, crash, ego) for ego in egos]


def role_title(number: int | None) -> str:
    """The same in words for a reader: "vehicle 1", "onlooker"."""
    return "onlooker" if number is None else f"vehicle {number}"


def plain_name(text: str) -> str:
    """A text as scenarios and their files are called by: characters that a name may not have become '-'."""
    return re.sub(r"[^A-Za-z0-9_.\-]", "-", text)


def draw_scenario(role: CrashRole, index: int, seed: int = 0) -> world.Scenario:
    """Draw what a report leaves open; the same report, role, index and seed give the same scenario.

    Raises:
        InputError: no road network can be built for the report.
    """
    drawn = sample(open_questions(role.crash), generator_of(role, f"{seed}/{index}"))
    return build_scenario(role, drawn, f"{role.report}-{role.name}-{index}", seed)


def generator_of(role: CrashRole, purpose: str) -> random.Random:
    """Random numbers that depend on the report, the role and the purpose alone."""
    return random.Random(f"roadmend/safe/{role.report}/{role.number or role.name}/{purpose}")


def build_scenario(role: CrashRole, drawn: Parameters, name: str, seed: int) -> world.Scenario:
    """The scenario that a point of the open questions stands for.

    Args:
        role: the report, and who is the ego in it; one who looks on only where one vehicle crashes alone.
        drawn: a point of :func:`roadmend.safe.open_questions.open_questions`.
        name: of the scenario, see ``plain_name``.
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
    friction = environment.effective_friction
    stage: MeetingStage | OnlookerStage
    if role.ego is None:
        stage = OnlookerStage(role.crash, crash, layout, drawn, friction)
    else:
        stage = MeetingStage(role.crash, role.ego, crash, layout, drawn, friction)
    return world.Scenario(
        name=plain_name(name),
        seed=seed,
        time_limit=EDGE_OF_LIFE,
        network=layout.network,
        ego=stage.ego(),
        actors=stage.actors(),
        obstacles=stage.obstacles(),
        environment=environment,
        origin=world.ReportOrigin(
            report=role.report, vehicle=role.number, sampled=dict(drawn), adapted=[*layout.adapted, *stage.adapted]
        ),
    )
