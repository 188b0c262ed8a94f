"""What no message of another stack tells, for the node and for bags alike: names, defaults, ranges and meanings."""

from pydantic import Field

from roadmend.core.parameters import Parameters
from roadmend.recording import messages
from roadmend.recording.foreign_commands import COMMAND_FORMS, PEDALS, Pedals
from roadmend.recording.foreign_objects import OBJECT_READERS, EgoOutline
from roadmend.repair.parameters import FullBrake

PATIENCE_S = 0.3  # [s] after which an input counts as late, where nobody says otherwise: three messages at 10 Hz
PATIENCE_MAX_S = 60.0  # [s]


class ForeignParameters(Parameters):
    """Parameters of inputs from another stack, read once at start."""

    objects_type: str = Field(
        messages.OBJECTS.name, description=f"type of the topic objects: {' or '.join(OBJECT_READERS)}"
    )
    command_type: str = Field(
        messages.COMMAND.name,
        description=f"type of the topics policy/command and repair/command: {' or '.join(COMMAND_FORMS)}",
    )
    ego_length: float = Field(messages.EGO_SIZE[0], ge=0.1, le=60.0, description="of the ego's outline [m]")
    ego_width: float = Field(messages.EGO_SIZE[1], ge=0.1, le=10.0, description="of the ego's outline [m]")
    ego_centre: float = Field(
        0.0, ge=-30.0, le=30.0, description="centre of the outline, ahead of the frame that odometry is about [m]"
    )
    full_throttle: float = Field(
        PEDALS.full_throttle,
        ge=0.1,
        le=20.0,
        description="acceleration at full throttle, where commands are accelerations [m/s2]",
    )
    full_brake: FullBrake = PEDALS.full_brake

    @property
    def outline(self) -> EgoOutline:
        """What odometry does not tell of the ego."""
        return EgoOutline(self.ego_length, self.ego_width, self.ego_centre)

    @property
    def pedals(self) -> Pedals:
        """What the vehicle makes of its pedals."""
        return Pedals(self.full_throttle, self.full_brake)
