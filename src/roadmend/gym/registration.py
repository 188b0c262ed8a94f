"""How Gymnasium gets to know the environment; loads nothing that drives."""

from roadmend.core.extras import extra_missing

try:
    from gymnasium.envs import registration
except ModuleNotFoundError as error:
    raise extra_missing(error) from None

ENVIRONMENT = "roadmend/Drive-v0"


def register() -> None:
    """Make the environment known; harmless when it is known already."""
    if ENVIRONMENT not in registration.registry:
        registration.register(
            ENVIRONMENT,
            entry_point="roadmend.gym.drive:DriveEnv",
            vector_entry_point="roadmend.gym.vector:make_vector",
        )
