"""Lets an intervention begin only where a model's need monitor foresees a collision, and says where it must be hard."""

from roadmend.core.command import Decision
from roadmend.core.scene import Scene
from roadmend.repair.adreft.history import History
from roadmend.repair.adreft.model import AdreftModel
from roadmend.repair.adreft.risk_monitor import RiskMonitor
from roadmend.repair.adreft.tokenizer import TokenSet

NEVER = 1.0  # a bar that no score is above


class NeedGate:
    """Raises the bar of an intervention that has not begun and is not needed.

    Once it has begun, the score alone decides how long it lasts: of a moment in the middle of an intervention the need
    monitor has seen none. That the risk has stayed high while the ego braked it can tell, and then mild braking is not
    enough.

    Args:
        model: of ADReFT; without a need monitor every intervention is needed.
        threshold: risk above which it is; below 0 the model's own, at 0 always.
    """

    def __init__(self, model: AdreftModel, threshold: float) -> None:
        self._monitor = model.need
        self.threshold = 0.0 if self._monitor is None else self._monitor.threshold(threshold)
        self._pressing = model.configuration.pressing
        self._history = History()
        self._tokens: TokenSet | None = None  # of this tick
        self._risk: float | None = None  # of this tick, where it was asked for already
        self._is_open = False

    def reset(self) -> None:
        """Begin an episode."""
        self._history.reset()
        self._tokens = self._risk = None
        self._is_open = False

    def see(self, scene: Scene, decision: Decision, tokens: TokenSet) -> None:
        """Take in a tick, before anything is asked about it; every one of them, in order."""
        self._tokens, self._risk = tokens, None
        if self._monitor is not None and self._monitor.configuration.history:
            self._history.see(scene, decision)

    def bar(self, score: float, threshold: float, bar: float) -> tuple[float, str]:
        """What the score must be above at this tick, and why where that is more than it was.

        Args:
            score: how critical the scene is.
            threshold: at which an intervention has ended.
            bar: above which one is called for; not below the threshold.

        Raises:
            FloatingPointError: the risk is not finite.
        """
        if score <= threshold:
            self._is_open = False
        elif score > bar and not self._is_open and self._monitor is not None and self.threshold > 0.0:
            risk = self._risk_of_tick(self._monitor)
            if risk <= self.threshold:
                return NEVER, f"criticality {score:.3f}, but not needed: risk {risk:.3f} not above {self.threshold:.3f}"
            self._is_open = True
        return bar, ""

    def pressing_risk(self) -> float | None:
        """The risk of a tick of an intervention where it is so high that nothing but full braking will do, else None.

        Raises:
            FloatingPointError: the risk is not finite.
        """
        if self._monitor is None or self._pressing == 0.0:
            return None
        risk = self._risk_of_tick(self._monitor)
        return risk if risk > self._pressing else None

    def _risk_of_tick(self, monitor: RiskMonitor) -> float:
        if self._tokens is None:
            raise RuntimeError("no tick was seen")
        if self._risk is None:
            has_history = monitor.configuration.history
            self._risk = monitor.risk(self._history.extend(self._tokens) if has_history else self._tokens.values)
        return self._risk
