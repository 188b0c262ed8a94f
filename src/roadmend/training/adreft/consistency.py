"""Whether the sections of a configuration go together: said before a folder is made or anybody drives."""

from roadmend.core.errors import InputError
from roadmend.training.adreft.configuration import FORESEEING, TrainingConfiguration


def check_configuration(configuration: TrainingConfiguration, only: str | None = None) -> None:
    """Whether there is such a model, all stages speak of the same kind of adapter, and the one asked for does something.

    Args:
        configuration: of a training.
        only: the stage that was asked for, see ``pipeline.Pipeline.run``.

    Raises:
        InputError: no.
    """
    configuration.model.configuration()
    if only == "reinforcement" and not (configuration.reinforcement.episodes or configuration.rollouts.rounds):
        mend = "set reinforcement.episodes or rollouts.rounds, or leave --only out"
        raise InputError("--only", "this configuration has no fine-tuning", mend)
    practice = configuration.practice
    foresees = configuration.model.weighing is not None
    if foresees != (practice.epochs > 0 and practice.method in FORESEEING):
        mend = "set both, or neither: prices are what practice by counterfactuals or futures is weighed with"
        raise InputError("model.weighing", "does not go with practice.method", mend)
    if practice.method == "counterfactual" and foresees and practice.rounds > 1:
        mend = "set it to 1, or practice.method to fitted_q or futures"
        raise InputError("practice.rounds", "counterfactuals are of the policy alone, with no model along", mend)
    if foresees and configuration.reinforcement.episodes:
        mend = "set it to 0 and rollouts.rounds to what is wanted, or practice.method to fitted_q"
        raise InputError("reinforcement.episodes", "a DQN takes an adapter that gives values", mend)
    if configuration.rollouts.rounds and not (foresees and practice.method == "futures"):
        mend = "set it to 0, or practice.method to futures"
        raise InputError("rollouts.rounds", "rollouts take an adapter that foresees, and its harmless drives", mend)
