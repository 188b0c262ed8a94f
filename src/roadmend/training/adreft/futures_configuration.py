"""Hyper-parameters of practice on futures: the single source of default, range and meaning."""

from pydantic import Field

from roadmend.core.parameters import Parameters


class FuturesSection(Parameters):
    """Practice on what comes of a moment, over and over, with and without a pulse of braking (see ``moments``)."""

    start: str | None = Field(
        None, description="model of ADReFT to begin with: a shipped one by its policy's name, or a file; none: none"
    )
    moments: int = Field(
        6,
        ge=1,
        le=1000,
        description="moments that are looked at in a drive, about: each of its parts (a violation's last 4 s, the 4 s before "
        "them, what is before that; what may come after the end) has at least one",
    )
    futures: int = Field(4, ge=1, le=100, description="futures of a moment, the same ones with every pulse")
    pulsed: int = Field(1, ge=0, le=100, description="drives of a case with pulses at random times, besides the plain")
    pulse: float = Field(0.6, ge=0.05, le=5.0, description="how long a tried action is held [s]")
    actions: int = Field(2, ge=0, le=9, description="actions that are tried where some future violates alone")
    harmless: float = Field(0.25, ge=0.0, le=1.0, description="probability that one is tried where none does")
    cases: int = Field(
        0, ge=0, le=100_000, description="training cases of every policy that drives, spread over the families; 0: all"
    )
    random_cases: int = Field(
        100, ge=0, le=100_000, description="scenarios of each family drawn at random for every policy that drives"
    )
    random_validation: int = Field(20, ge=0, le=100_000, description="the same for validation, of the policy's own")
    base_rate: float = Field(0.036, gt=0.0, lt=1.0, description="share of drives that violate on ordinary ways")
    weight_exponent: float = Field(
        0.5,
        ge=0.0,
        le=1.0,
        description="of a moment's weight in the loss: at 1 violations weigh as they occur, at 0 all moments alike",
    )
    recalibrate: bool = Field(
        default=True, description="make probabilities of score and danger by the validation moments (recalibration)"
    )
    touched: float = Field(
        0.1, ge=0.0, lt=1.0, description="at most this share of harmless validation drives scores above the threshold"
    )
