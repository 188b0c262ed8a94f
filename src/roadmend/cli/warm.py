"""``python -m roadmend.cli.warm``: compile every kernel once, so that the first run does not wait for the compiler."""

from roadmend.core.errors import InputError
from roadmend.policies.registry import POLICIES, make_policy
from roadmend.repair.registry import METHODS, make_repairer
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode


def main() -> None:
    """Run a few seconds of one scenario with every policy and every method."""
    for policy in POLICIES:
        for method in METHODS:
            try:
                repairer = make_repairer(method)
            except InputError:  # a model that does not ship yet, or no longer fits
                continue
            repairer.warm_up()
            for family in ("S1", "S5"):
                scenario = sample_scenario(family, 0).model_copy(update={"time_limit": 4.0})
                run_episode(scenario, make_policy(policy), repairer)


if __name__ == "__main__":
    main()
