"""Every hyper-parameter of ADReFT's training: the single source of default, range and meaning.

The defaults are the paper's where the paper names a value (config/training/adreft-paper.yaml).
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import Field, ValidationError, model_validator

from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.settings import check_settings, describe
from roadmend.core.yaml_file import read_fields
from roadmend.networks.shape import EncoderShape
from roadmend.repair.adreft.configuration import Deciding, ModelConfiguration
from roadmend.repair.adreft.registry import make_tokenizer
from roadmend.training.adreft.futures_configuration import FuturesSection
from roadmend.training.adreft.rollouts_configuration import RolloutsSection

FORESEEING = ("counterfactual", "futures")  # methods of practice whose adapter foresees collisions
LearningRate = Annotated[float, Field(gt=0.0, le=1.0, description="learning rate")]


class ModelSection(Deciding):
    """The networks (ADReFT section 3.1)."""

    tokenizer: str = Field("paper", description="name of the tokenizer")
    hidden: int = Field(64, ge=4, le=1024, description="H, width of the state encoder")
    layers: int = Field(2, ge=1, le=12, description="layers of the state encoder")
    heads: int = Field(4, ge=1, le=64, description="attention heads of a layer")
    feed_forward: int = Field(128, ge=4, le=4096, description="width of a layer's feed-forward part")
    activation: Literal["relu", "gelu"] = Field("relu", description="of the feed-forward part")

    def configuration(self) -> ModelConfiguration:
        """The configuration of such a model.

        Raises:
            InputError: there is no such tokenizer, the heads do not share the width evenly, or the rules of deciding ask
                for what no training of ADReFT gives.
        """
        tokenizer = make_tokenizer(self.tokenizer)
        try:
            encoder = EncoderShape(
                attributes=tokenizer.attributes,
                hidden=self.hidden,
                layers=self.layers,
                heads=self.heads,
                feed_forward=self.feed_forward,
                activation=self.activation,
            )
        except ValidationError as error:
            raise InputError("model", describe(error), "choose a width that the heads divide") from None
        try:
            return ModelConfiguration(
                tokenizer=tokenizer.name,
                tokenizer_version=tokenizer.version,
                encoder=encoder,
                **{name: getattr(self, name) for name in Deciding.model_fields},
            )
        except ValidationError as error:
            mend = "train without it; then './roadmend train need', and './roadmend train adjust' sets it"
            raise InputError("model", describe(error), mend) from None


class FramesSection(Parameters):
    """Which frames are learned from, and their labels."""

    labels: str = Field("weak", description="label scheme of the supervised stage")
    stride: int = Field(1, ge=1, le=100, description="every so many-th tick of a training case is a frame")
    validation_stride: int = Field(1, ge=1, le=100, description="the same for validation cases")


class SupervisedSection(Parameters):
    """The supervised stage (ADReFT section 3.2.1)."""

    epochs: int = Field(200, ge=0, le=10_000, description="passes over the frames; 0 leaves the stage out")
    learning_rate: LearningRate = 1e-4
    schedule: Literal["constant", "cosine"] = Field("constant", description="of the learning rate over the epochs")
    optimizer: Literal["adam", "adamw"] = Field("adam", description="AdamW decays weights apart from the gradient")
    weight_decay: float = Field(0.0, ge=0.0, le=1.0, description="weight decay")
    clip: float = Field(0.0, ge=0.0, le=1000.0, description="largest norm of the gradient; 0: not clipped")
    batch: int = Field(256, ge=1, le=65_536, description="frames of a batch")
    frames_per_epoch: int = Field(0, ge=0, le=100_000_000, description="frames drawn for an epoch; 0: all, once each")
    critical_share: float | None = Field(
        None, gt=0.0, lt=1.0, description="share of critical frames in an epoch; none: as they come"
    )
    critical_weight: float = Field(
        1.0, gt=0.0, le=1000.0, description="weight of critical frames in the monitor's loss"
    )
    adapter_weight: float = Field(1.0, ge=0.0, le=1000.0, description="weight of the adapter's loss")
    recall: float = Field(
        0.95, ge=0.0, lt=1.0, description="the threshold recognises more than this share of the critical frames"
    )
    keep: Literal["f1", "loss", "last"] = Field("f1", description="by what on validation the best epoch is chosen")
    validate_every: int = Field(1, ge=1, le=1000, description="epochs between two validations")
    save_every: int = Field(1, ge=1, le=1000, description="epochs between two states from which training can go on")


class PracticeSection(Parameters):
    """Practice on trials, ours: values of random interventions instead of labels (see ``practice``)."""

    epochs: int = Field(0, ge=0, le=10_000, description="passes over the trials; 0 leaves the stage out")
    method: Literal["fitted_q", "counterfactual", "futures"] = Field(
        "fitted_q",
        description="learn values, or collisions with and without an intervention (model.weighing: prices), of trials "
        "or of futures",
    )
    rounds: int = Field(
        1, ge=1, le=100, description="times that trials are driven; from the second on the model so far drives along"
    )
    later_epochs: int = Field(8, ge=1, le=10_000, description="passes over all trials so far, in later rounds")
    later_learning_rate: LearningRate = 5e-4
    later_blinded: int = Field(0, ge=0, le=100, description="as blinded and random_blinded, in later rounds")
    forget: float = Field(
        0.0, ge=0.0, le=1.0, description="share of bystanders left out of each scene that is learned; rich tokens only"
    )
    per_violation: int = Field(8, ge=0, le=1000, description="trials of a violation, besides the policy alone")
    per_success: int = Field(2, ge=0, le=1000, description="trials of a success, besides the policy alone")
    gentle_per_violation: int = Field(
        0, ge=0, le=1000, description="long and mild trials of a violation, besides those"
    )
    gentle_per_success: int = Field(0, ge=0, le=1000, description="long and mild trials of a success, besides those")
    blinded: int = Field(
        1,
        ge=0,
        le=100,
        description="times that a success is driven blinded; if it collides it gets per_violation trials",
    )
    random_cases: int = Field(
        0, ge=0, le=100_000, description="scenarios of each family drawn at random for every policy that drives"
    )
    random_blinded: int = Field(2, ge=0, le=100, description="as blinded, of scenarios drawn at random")
    interval: int = Field(4, ge=1, le=100, description="ticks between two decisions")
    dropout: float = Field(0.0, ge=0.0, lt=1.0, description="share of a state's entries that the heads do not see")
    weight_decay: float = Field(1e-4, ge=0.0, le=10.0, description="of AdamW")
    learning_rate: LearningRate = 1e-3
    batch: int = Field(256, ge=1, le=65_536, description="decisions of a batch")
    decisions_per_epoch: int = Field(
        0, ge=0, le=100_000_000, description="decisions drawn for an epoch; 0: all, once each"
    )
    tried_per_epoch: int = Field(
        0, ge=0, le=100_000_000, description="counterfactual: decisions of interventions drawn besides; 0: all"
    )
    lasting: float = Field(
        1.0, gt=0.0, le=10.0, description="counterfactual: how long an intervention's decisions tell of its begin [s]"
    )
    monte_carlo_epochs: int = Field(
        2, ge=0, le=10_000, description="epochs that learn what the episodes came to; later ones ask the network"
    )
    steps: int = Field(4, ge=1, le=1000, description="decisions whose rewards are counted before the network is asked")
    gamma: float = Field(0.98, ge=0.0, le=1.0, description="discount of a decision")
    violation: float = Field(-10.0, ge=-1000.0, le=0.0, description="reward of a collision")
    timeout: float = Field(-10.0, ge=-1000.0, le=0.0, description="reward of an episode that never reaches its goal")
    dose: float = Field(1.0, ge=0.0, le=1000.0, description="price of a second of full command")
    dose_exponent: float = Field(
        1.0,
        ge=1.0,
        le=4.0,
        description="of the strength of an intervention in its price; above 1 gentle and long is cheap",
    )
    time: float = Field(0.02, ge=0.0, le=10.0, description="price of a decision's time")
    near: float = Field(1.0, ge=0.0, le=10.0, description="delta_d: nearer than this is critical [m]")
    before_collision: float = Field(3.0, ge=0.0, le=10.0, description="delta_t: critical before a collision [s]")

    def of_round(self, number: int) -> Self:
        """What holds in a round, counted from 0: later ones go on from what was learned."""
        if number == 0:
            return self
        changes = {"epochs": self.later_epochs, "learning_rate": self.later_learning_rate, "monte_carlo_epochs": 0}
        return self.model_copy(update={**changes, "blinded": self.later_blinded, "random_blinded": self.later_blinded})


class ReinforcementSection(Parameters):
    """Reinforcement fine-tuning (ADReFT section 3.2.2)."""

    episodes: int = Field(300, ge=0, le=1_000_000, description="episodes driven in all; 0 leaves the stage out")
    violation_share: float = Field(0.5, ge=0.0, le=1.0, description="share of violations among the episodes")
    round: int = Field(
        1, ge=1, le=1000, description="episodes driven side by side on the same adapter before it learns from them"
    )
    start: Literal["supervised", "scratch"] = Field(
        "supervised", description="the adapter to begin with; from scratch is the ablation 'only RL'"
    )
    learning_rate: LearningRate = 1e-4
    memory: int = Field(5000, ge=1, le=10_000_000, description="transitions remembered; the oldest are forgotten")
    batch: int = Field(64, ge=1, le=65_536, description="transitions of an update")
    updates_per_step: float = Field(1.0, gt=0.0, le=100.0, description="updates for each new transition")
    warm_up: int = Field(500, ge=1, le=10_000_000, description="transitions before the first update")
    target_every: int = Field(500, ge=1, le=1_000_000, description="updates between two copies to the target network")
    gamma: float = Field(0.99, ge=0.0, le=1.0, description="discount of a tick")
    steps: int = Field(1, ge=1, le=1000, description="rewards in a return before the target network's estimate")
    double: bool = Field(default=False, description="double DQN: the online network chooses what the target values")
    clip: float = Field(10.0, ge=0.0, le=1000.0, description="largest norm of the gradient; 0: not clipped")
    loss: Literal["squared", "huber"] = Field("squared", description="of the temporal difference")
    interval: int = Field(1, ge=1, le=100, description="ticks for which a decision of the adapter holds")
    decisions: Literal["all", "critical"] = Field(
        "all", description="at which ticks the adapter decides: at all, or where the monitor steps in"
    )
    action: Literal["proposed", "executed"] = Field(
        "proposed", description="what is learned from: the adapter's choice, or the action nearest to what was done"
    )
    epsilon_begin: float = Field(1.0, ge=0.0, le=1.0, description="probability of a uniformly random action at first")
    epsilon_end: float = Field(0.05, ge=0.0, le=1.0, description="the same at last")
    epsilon_share: float = Field(0.5, gt=0.0, le=1.0, description="share of the episodes over which it falls")
    step_reward: bool = Field(default=True, description="reward of every step; without it the ablation 'wo SR'")
    violation: float = Field(-10.0, ge=-1000.0, le=0.0, description="reward of a collision")
    timeout: float = Field(0.0, ge=-1000.0, le=0.0, description="reward of an episode that never reaches its goal")
    goal: float = Field(0.0, ge=0.0, le=1000.0, description="reward of a goal reached")
    dose: float = Field(
        0.0, ge=0.0, le=1000.0, description="price of a second of full command: |policy's - final action| * interval"
    )
    dose_exponent: float = Field(
        1.0, ge=1.0, le=4.0, description="of the strength of an intervention in its price, as in practice"
    )
    time: float = Field(0.0, ge=0.0, le=10.0, description="price of a decision's time, as in practice")
    validate_every: int = Field(10, ge=1, le=100_000, description="rounds between two validations in closed loop")
    validation_cases: int = Field(
        0, ge=0, le=100_000, description="validation cases driven each time, spread over the families; 0: all"
    )
    keep: Literal["best", "last"] = Field("best", description="the adapter that fared best on validation, or the last")
    dose_weight: float = Field(
        1.0, ge=0.0, le=1000.0, description="points [%] that a second of mean dose costs in the choice of the best"
    )
    late_weight: float = Field(
        0.0, ge=0.0, le=100.0, description="points that a per cent of successes without collision or goal costs there"
    )
    intensity_weight: float = Field(0.0, ge=0.0, le=1000.0, description="the same for an intensity of 1")


class TrainingConfiguration(Parameters):
    """All of it."""

    model: ModelSection = ModelSection()
    frames: FramesSection = FramesSection()
    supervised: SupervisedSection = SupervisedSection()
    practice: PracticeSection = PracticeSection()
    futures: FuturesSection = FuturesSection()
    rollouts: RolloutsSection = RolloutsSection()
    reinforcement: ReinforcementSection = ReinforcementSection()
    threads: int = Field(1, ge=1, le=256, description="threads of torch; the bits may depend on it")

    @model_validator(mode="after")
    def _check_forget(self) -> Self:
        if self.practice.forget and self.model.tokenizer != "rich":
            raise ValueError("practice.forget: only rich tokens tell who is a bystander; leave it at 0")
        return self


def read_training_configuration(path: Path, changes: Mapping[str, Any] | None = None) -> TrainingConfiguration:
    """Read a configuration file; what it does not name has its default.

    Args:
        path: YAML.
        changes: values that take the place of the file's, by "section.name".

    Raises:
        InputError: the file is missing, is no YAML, or a field of it is unusable.
    """
    content = read_fields(path, "see config/training for examples")
    for name, value in (changes or {}).items():
        section, _, field = name.partition(".")
        fields = content.get(section) or {}
        if not isinstance(fields, dict):
            raise InputError(str(path), f"{section} is no section", "see config/training/adreft.yaml")
        content[section] = fields | ({field: value} if field else value)
    return check_settings(
        content, TrainingConfiguration, str(path), "see config/training/adreft.yaml for names and ranges"
    )
