"""The paper's ModelRepair: an autoencoder that does not know the scene pulls the brake (ADReFT section 4.1).

After SelfOracle (Stocco, Weiss, Calzana, Tonella 2020, arXiv:1910.04443): an autoencoder is trained on what successful
drives look like, a gamma distribution is fitted to its reconstruction errors, and an error beyond the quantile of a
chosen false alarm rate means that the situation is none of those. The input here is a state vector, not an image.
"""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, ValidationError

from roadmend.core.command import Decision
from roadmend.core.errors import InputError
from roadmend.core.parameters import Parameters
from roadmend.core.repair import Proposal
from roadmend.core.route import Route
from roadmend.core.scene import Scene
from roadmend.networks.checkpoint import find_model, load_checkpoint
from roadmend.networks.compiled_encoder import CompiledHead
from roadmend.networks.shape import HeadShape
from roadmend.repair.parameters import ModelParameters
from roadmend.repair.state_vector import SIZE, VERSION, state_vector

KIND = "self_oracle"
CLIP = 5.0  # standardised inputs beyond this are taken as this


class Configuration(Parameters):
    """Saved in every model's header: what it is built from."""

    vector_version: int = Field(ge=1, description="version of the state vector that the model was trained with")
    autoencoder: HeadShape = Field(description="shape of the autoencoder, encoder and decoder in one")
    thresholds: dict[str, float] = Field(
        description="threshold by false alarm rate, from the fitted gamma distribution"
    )


class SelfOracleModel:
    """The autoencoder as it runs: compiled, without torch.

    Args:
        configuration: what it is built from.
        tensors: "autoencoder." and the standardisation's "mean" and "scale", shape (SIZE,) each.
        digest: of the model's file.

    Raises:
        ValueError: a tensor is missing, has another shape or holds what is not finite.
    """

    def __init__(self, configuration: Configuration, tensors: Mapping[str, NDArray[Any]], digest: str = "") -> None:
        self.configuration = configuration
        self.digest = digest
        self._autoencoder = CompiledHead(configuration.autoencoder, tensors, "autoencoder.")
        self._mean, self._scale = (np.asarray(tensors.get(name), dtype=np.float32) for name in ("mean", "scale"))
        for values in (self._mean, self._scale):
            if values.shape != (SIZE,) or not np.isfinite(values).all():
                raise ValueError(f"mean and scale: {SIZE} finite numbers wanted")

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a model's file.

        Raises:
            InputError: it is missing, damaged, no such model, or does not fit this version of roadmend.
        """
        checkpoint = load_checkpoint(path, KIND)
        mend = "train the model again with this version of roadmend"
        try:
            given = checkpoint.header["configuration"]["model"]
            configuration = Configuration.model_validate_json(json.dumps(given))
        except (ValidationError, KeyError, TypeError):
            raise InputError(str(path), "its configuration is not that of a SelfOracle model", mend) from None
        if configuration.vector_version != VERSION:
            what = f"was trained with version {configuration.vector_version} of the state vector, not {VERSION}"
            raise InputError(str(path), what, mend)
        try:
            return cls(configuration, checkpoint.tensors, checkpoint.digest)
        except ValueError as error:
            raise InputError(str(path), str(error), mend) from None

    def standardise(self, vectors: NDArray[np.float32]) -> NDArray[np.float32]:
        """State vectors as the autoencoder takes them, shape (..., SIZE)."""
        scaled: NDArray[np.float32] = np.clip((vectors - self._mean) / self._scale, -CLIP, CLIP).astype(np.float32)
        return scaled

    def error(self, vector: NDArray[np.float32]) -> float:
        """Mean squared reconstruction error of a state vector, shape (SIZE,)."""
        wanted = self.standardise(vector)
        difference = (self._autoencoder.apply(wanted) - wanted).tolist()
        return math.fsum(value * value for value in difference) / SIZE

    def threshold(self, false_alarm_rate: float) -> float:
        """The reconstruction error that nominal frames exceed with this probability.

        Raises:
            InputError: the model has no threshold for this rate.
        """
        thresholds = self.configuration.thresholds
        found = thresholds.get(f"{false_alarm_rate:g}")
        if found is None:
            where = "model.false_alarm_rate"
            raise InputError(
                where, f"there is no {false_alarm_rate:g}", f"choose one of: {', '.join(sorted(thresholds, key=float))}"
            )
        return found


class ModelRepair:
    """Emergency brake while the scene is out of distribution.

    Score: the reconstruction error; threshold: the error that the fitted gamma distribution exceeds with the false
    alarm rate. Nobody is named as a trigger: the autoencoder does not tell.
    """

    name = "model"

    def __init__(self, parameters: ModelParameters | None = None, model: SelfOracleModel | None = None) -> None:
        """Load the model.

        Args:
            parameters: which model, and at which false alarm rate.
            model: one that is loaded already, instead.

        Raises:
            InputError: there is no such model, it does not fit, or it has no threshold for the rate.
        """
        parameters = parameters or ModelParameters()
        self.model = model or SelfOracleModel.load(find_model(parameters.model, "self_oracle-"))
        self._threshold = self.model.threshold(parameters.false_alarm_rate)

    def reset(self, route: Route) -> None:
        """Nothing is remembered."""

    def propose(self, scene: Scene, decision: Decision) -> Proposal:
        """Judge one tick."""
        error = self.model.error(state_vector(scene, decision))
        if not error > self._threshold:
            return Proposal(error, self._threshold, -1.0)
        reason = f"reconstruction error {error:.3f} above {self._threshold:.3f}: the scene is unfamiliar"
        return Proposal(error, self._threshold, -1.0, reason=reason)
