"""Hyper-parameters of reinforcement fine-tuning by rollouts: the single source of default, range and meaning."""

from pydantic import Field

from roadmend.core.parameters import Parameters


class RolloutsSection(Parameters):
    """Reinforcement fine-tuning of an adapter that foresees collisions (see ``rollouts``)."""

    rounds: int = Field(
        0, ge=0, le=100, description="times that the model drives and learns from it; 0 leaves the stage out"
    )
    moments: int = Field(4, ge=1, le=1000, description="moments at most of a drive")
    futures: int = Field(4, ge=1, le=100, description="futures of a moment, the same ones with every choice")
    actions: int = Field(3, ge=1, le=9, description="actions that are tried at a moment, besides waiting")
    score: float = Field(
        0.02, ge=0.0, lt=1.0, description="a moment is looked at where the monitor's score is above this"
    )
    chance: float = Field(
        0.1, gt=0.0, le=1.0, description="probability that such a tick is looked at, after the first of a drive"
    )
    random_cases: int = Field(
        60, ge=0, le=100_000, description="scenarios of each family drawn at random, besides the training cases"
    )
    violation_cases: int = Field(0, ge=0, le=100_000, description="violations of the training split; 0: all")
    success_cases: int = Field(0, ge=0, le=100_000, description="its successes; 0: all")
    touched: float = Field(
        0.2,
        ge=0.0,
        lt=1.0,
        description="the monitor asks the adapter in at most this share of harmless validation drives; the adapter may "
        "then leave the policy alone",
    )
    time: float = Field(
        0.5, ge=0.0, le=1000.0, description="price of a second lost, where a collision's is model.weighing.collision"
    )
    epochs: int = Field(40, ge=1, le=10_000, description="passes over all that was tried so far")
    learning_rate: float = Field(3e-4, gt=0.0, le=1.0, description="learning rate")
    weight_decay: float = Field(0.01, ge=0.0, le=10.0, description="of AdamW")
    dropout: float = Field(0.1, ge=0.0, lt=1.0, description="share of a state's entries that the adapter does not see")
    batch: int = Field(128, ge=1, le=65_536, description="moments of a batch")
    held_out: float = Field(
        0.2, gt=0.0, lt=1.0, description="share of the cases by which the epoch that is kept is chosen"
    )
