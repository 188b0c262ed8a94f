"""``python -m roadmend.cli.warm``: compile every kernel once, so that the first run does not wait for the compiler."""

import sys

from roadmend.core.errors import InputError
from roadmend.policies.registry import POLICIES, make_policy
from roadmend.repair.registry import METHODS, make_repairer
from roadmend.world.families import sample_scenario
from roadmend.world.runner import run_episode


def main() -> None:
    """Run a few seconds of one scenario with every policy and every method.

    What lacks its model file is left out: a set-up must not fail for it, or nobody could train the model anew.
    """
    for policy in POLICIES:
        for method in METHODS:
            try:
                driver, repairer = make_policy(policy), make_repairer(method)
            except InputError as error:
                print(f"{policy} with {method} left out: {error}", file=sys.stderr)
                continue
            repairer.warm_up()
            for family in ("S1", "S5"):
                scenario = sample_scenario(family, 0).model_copy(update={"time_limit": 4.0})
                run_episode(scenario, driver, repairer)


if __name__ == "__main__":
    main()
