"""Parameters of the guard and of every method: the single source of default, range and meaning."""

from typing import Annotated, Literal

from pydantic import Field

from roadmend.core.parameters import Parameters

FullBrake = Annotated[float, Field(ge=0.5, le=20.0, description="deceleration of the ego at brake 1 [m/s2]")]
Hold = Annotated[float, Field(ge=0.0, le=2.0, description="least duration of an intervention [s]")]
Clear = Annotated[float, Field(ge=0.0, le=2.0, description="how long the scene must be clear before release [s]")]


class GuardParameters(Parameters):
    """What the guard does about faults."""

    stop_deceleration: float = Field(4.0, ge=1.0, le=8.0, description="deceleration of a controlled stop [m/s2]")
    full_brake: FullBrake = 8.0
    max_length: float = Field(60.0, ge=5.0, le=500.0, description="objects longer than this are dropped [m]")
    max_width: float = Field(10.0, ge=3.0, le=100.0, description="objects wider than this are dropped [m]")
    max_speed: float = Field(150.0, ge=30.0, le=1000.0, description="objects faster than this are dropped [m/s]")
    clock_jump: float = Field(1.0, ge=0.1, le=60.0, description="a larger step of the stamps resets the method [s]")
    budget: float | None = Field(
        None, gt=0.0, le=10.0, description="wall time a method may take per tick [s]; none: no limit"
    )


class RandomParameters(Parameters):
    """The paper's Random baseline."""

    probability: float = Field(0.1, ge=0.0, le=1.0, description="probability of stepping in at a tick")


class GovernorParameters(Parameters):
    """A lower speed limit: what it saves to drive slower, whoever is there."""

    share: float = Field(0.9, gt=0.1, le=1.0, description="of the speed limit at which it holds the ego")
    gain: float = Field(0.5, gt=0.0, le=10.0, description="brake for each [m/s] above that")


class RuleParameters(Parameters):
    """The paper's RuleRepair: time-to-collision to the object ahead."""

    time_to_collision: float = Field(3.0, ge=0.1, le=10.0, description="brake below this time to collision [s]")
    side_margin: float = Field(0.0, ge=0.0, le=2.0, description="objects this close beside the ego's swath count [m]")
    graded: bool = Field(
        default=False, description="brake with the mildest action that stops short of the object, not with the full one"
    )
    full_brake: FullBrake = 8.0


class RssParameters(Parameters):
    """Responsibility-Sensitive Safety; the symbols are those of Shalev-Shwartz et al. 2017."""

    rho: float = Field(0.5, ge=0.0, le=3.0, description="response time of every road user [s]")
    a_max_accel: float = Field(2.0, ge=0.0, le=6.0, description="acceleration within the response time [m/s2]")
    a_min_brake: float = Field(5.0, ge=1.0, le=8.0, description="deceleration of a proper response [m/s2]")
    a_max_brake: float = Field(8.0, ge=2.0, le=12.0, description="hardest deceleration of the one ahead [m/s2]")
    a_lateral_accel: float = Field(0.2, ge=0.0, le=2.0, description="lateral acceleration in response time [m/s2]")
    a_lateral_brake: float = Field(0.8, ge=0.1, le=4.0, description="least lateral deceleration [m/s2]")
    mu: float = Field(0.3, ge=0.0, le=2.0, description="lateral margin toward objects that close in sideways [m]")
    time_gap: float = Field(0.5, ge=0.0, le=3.0, description="least time between two users of a conflict area [s]")
    horizon: float = Field(5.0, ge=1.0, le=10.0, description="conflicts later than this do not count yet [s]")
    release: float = Field(0.2, ge=0.0, le=1.0, description="share of distance and time gap to gain before release")
    hold: Hold = 0.3
    clear: Clear = 0.1
    full_brake: FullBrake = 8.0


class PredictiveParameters(Parameters):
    """Rolls the scene forward and brakes where outlines will overlap."""

    horizon: float = Field(3.0, ge=0.5, le=8.0, description="how far ahead contacts are looked for [s]")
    interval: float = Field(0.1, ge=0.02, le=0.25, description="time step of the prediction [s]")
    margin: float = Field(0.3, ge=0.0, le=3.0, description="outlines nearer than this count as a contact [m]")
    turning: bool = Field(default=True, description="objects keep their yaw rate, not only their velocity")
    slowing: bool = Field(default=False, description="objects that brake keep braking until they stand")
    adaptive: bool = Field(
        default=True, description="take the mildest braking that avoids the contact, not always the full brake"
    )
    release: float = Field(0.25, ge=0.0, le=1.0, description="share by which margin and horizon grow until release")
    hold: Hold = 0.3
    clear: Clear = 0.1
    full_brake: FullBrake = 8.0


class ModelParameters(Parameters):
    """The paper's ModelRepair: emergency brake where an autoencoder does not know the scene."""

    model: str = Field("modular", description="a shipped SelfOracle model by its policy's name, or a model file's path")
    false_alarm_rate: float = Field(
        0.05, gt=0.0, lt=1.0, description="share of nominal frames that may alarm; one that the model was fitted for"
    )


class AdreftParameters(Parameters):
    """ADReFT: a trained model."""

    model: str = Field("modular", description="a shipped model of ADReFT by its policy's name, or a model file's path")
    threshold: float = Field(
        -1.0, ge=-1.0, le=1.0, description="steps in where the score is above this; below 0: the model's own threshold"
    )
    need_threshold: float = Field(
        -1.0,
        ge=-1.0,
        le=1.0,
        description="steps in only where the risk of not doing so is above this; below 0: the model's own, 0: always",
    )
    change_threshold: float = Field(
        -1.0,
        ge=-1.0,
        le=1.0,
        description="holds back a lane change whose risk is above this; below 0: the model's own, 1: never",
    )


class GatedParameters(AdreftParameters):
    """A rule that asks the monitor of a model of ADReFT first."""

    rule: Literal["rss", "predictive", "both"] = Field("both", description="what proposes the braking")
    horizon: float = Field(2.5, ge=0.5, le=8.0, description="of PredictiveBrake, as there [s]")
    margin: float = Field(0.3, ge=0.0, le=3.0, description="of PredictiveBrake, as there [m]")
    time_gap: float = Field(0.5, ge=0.0, le=3.0, description="of RSS, as there [s]")
    rss_horizon: float = Field(3.0, ge=1.0, le=10.0, description="horizon of RSS, as there [s]")
    full_brake: FullBrake = 8.0
