"""Parameters of the modular policy: the single source of default, range and meaning."""

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from roadmend.core.parameters import Parameters


class ModularParameters(Parameters):
    """What the modules of the modular policy are set to."""

    # Localisation
    arrival_offset: float = Field(
        0.3, ge=0.05, le=1.0, description="a lane change has arrived this near to its line [m]"
    )
    change_time: float = Field(3.0, ge=1.0, le=10.0, description="duration of the ego's lane change [s]")
    change_length_min: float = Field(12.0, ge=5.0, le=50.0, description="shortest lane change [m]")

    # Prediction
    yaw_rate_filter: float = Field(0.25, ge=0.0, le=2.0, description="time constant of the filter on yaw rates [s]")
    yaw_rate_decay: float = Field(
        1.5, ge=0.1, le=10.0, description="time constant of the decay of a predicted turn [s]"
    )
    braking_time: float = Field(2.0, ge=0.0, le=5.0, description="an object that brakes is taken to go on so long [s]")
    speeding_time: float = Field(1.0, ge=0.0, le=5.0, description="the same for one that speeds up [s]")

    # Behaviour: speed and followed vehicles
    acceleration: float = Field(2.2, ge=0.5, le=3.5, description="largest acceleration on a free road [m/s2]")
    merging_acceleration: float = Field(3.0, ge=0.5, le=3.5, description="the same for a merge [m/s2]")
    deceleration: float = Field(
        2.0, ge=0.5, le=4.0, description="comfortable deceleration toward limits and lines [m/s2]"
    )
    lateral_acceleration: float = Field(
        2.5, ge=0.5, le=5.0, description="largest lateral acceleration in curves [m/s2]"
    )
    headway: float = Field(1.2, ge=0.5, le=3.0, description="time gap to the vehicle ahead [s]")
    standstill_gap: float = Field(2.5, ge=0.5, le=6.0, description="gap to a standing vehicle ahead [m]")
    cut_in_horizon: float = Field(
        2.0,
        ge=0.0,
        le=5.0,
        description="who enters the lane within this counts as ahead, beyond 4 only where the ego yields [s]",
    )

    # Behaviour: right of way
    line_margin: float = Field(0.7, ge=0.0, le=5.0, description="the front stops this far before a line [m]")
    yellow_deceleration: float = Field(
        3.0, ge=1.0, le=6.0, description="stop for yellow up to this deceleration [m/s2]"
    )
    red_deceleration: float = Field(6.0, ge=2.0, le=8.0, description="stop for red up to this deceleration [m/s2]")
    hold_deceleration: float = Field(
        3.5, ge=1.0, le=8.0, description="give way at a line up to this deceleration [m/s2]"
    )
    stop_duration: float = Field(0.5, ge=0.0, le=5.0, description="stand this long at a stop sign [s]")
    gap_after: float = Field(
        1.2, ge=0.0, le=5.0, description="who has priority arrives this much after the ego has left [s]"
    )
    gap_before: float = Field(0.5, ge=0.0, le=5.0, description="who has priority has left this much before the ego [s]")
    trust: float = Field(3.5, ge=0.5, le=8.0, description="who must give way is trusted up to this deceleration [m/s2]")
    patience: float = Field(12.0, ge=1.0, le=60.0, description="waiting time after which gap margins are smallest [s]")
    impatience: float = Field(0.6, ge=0.0, le=0.95, description="share of the margins that waiting takes away")

    # Behaviour: lane changes
    change_front_headway: float = Field(
        0.4, ge=0.0, le=3.0, description="time gap to the vehicle ahead in the other lane [s]"
    )
    change_rear_headway: float = Field(
        0.5, ge=0.0, le=3.0, description="time gap to the vehicle behind in the other lane [s]"
    )
    change_gap: float = Field(2.5, ge=0.5, le=10.0, description="smallest gap to both [m]")
    change_rear_deceleration: float = Field(
        1.5, ge=0.0, le=4.0, description="deceleration that a change may ask of others [m/s2]"
    )
    change_front_deceleration: float = Field(
        2.5, ge=0.5, le=6.0, description="deceleration behind the new leader [m/s2]"
    )
    change_horizon: float = Field(
        8.0, ge=1.0, le=8.0, description="how far ahead gaps are looked for, at most as far as is predicted [s]"
    )

    # Planner
    planning_interval: float = Field(
        0.1, ge=0.01, le=0.5, description="a new plan this often; the controller works at every tick [s]"
    )
    side_margin: float = Field(0.25, ge=0.0, le=1.0, description="lateral clearance to vehicles [m]")
    pedestrian_margin: float = Field(0.6, ge=0.0, le=3.0, description="lateral clearance to pedestrians [m]")
    front_margin: float = Field(0.6, ge=0.0, le=3.0, description="clearance ahead in the collision check [m]")
    time_margin: float = Field(0.3, ge=0.0, le=2.0, description="clearance in time in the collision check [s]")
    jerk: float = Field(4.0, ge=1.0, le=20.0, description="largest jerk outside emergencies [m/s3]")

    # Controller: the vehicle as its maker describes it, on a dry road
    engine_acceleration: float = Field(
        3.5, ge=1.0, le=10.0, description="acceleration at full throttle, low speed [m/s2]"
    )
    engine_power: float = Field(60.0, ge=10.0, le=300.0, description="engine power per mass [W/kg]")
    full_brake: float = Field(8.0, ge=2.0, le=12.0, description="deceleration at full brake [m/s2]")
    drag: float = Field(0.00027, ge=0.0, le=0.01, description="air drag per mass [1/m]")
    rolling: float = Field(0.12, ge=0.0, le=1.0, description="rolling resistance [m/s2]")
    integral_gain: float = Field(0.3, ge=0.0, le=2.0, description="correction of the model per missed speed [1/s2]")
    integral_limit: float = Field(0.6, ge=0.0, le=2.0, description="largest correction of the model [m/s2]")
    standstill_brake: float = Field(0.3, ge=0.1, le=1.0, description="brake held while standing")

    def packed(self) -> NDArray[np.void]:
        """All values as one record of floats, shape (1,), which compiled code reads by name."""
        values = self.model_dump()
        record = np.zeros(1, dtype=np.dtype([(name, np.float64) for name in values], align=True))
        record[0] = tuple(values.values())
        return record
