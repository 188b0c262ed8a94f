"""Letting go: a repair that brakes to a standstill and waits for ever repairs nothing."""

from roadmend.core.scene import Scene

STANDING = 0.3  # [m/s] below this speed the ego stands
_PAUSE = 0.5  # [s] between two ticks beyond which nobody knows what happened
_TICK = 1e-6  # [s] slack against rounding in sums of ticks


class Patience:
    """Raises the bar for an intervention that has lasted too long, or under which the ego has stood too long.

    Time counts while the command is replaced, from when the score was last at or below its threshold. When patience
    ends, the bar goes up half the way from the score to certainty, and stays there until the score has once fallen to
    the threshold. So what held the ego up no longer does, and where the ego rolls into what was feared, the score rises
    above the bar and it is stopped again. The bar is raised once: a second time would lead into the collision.
    """

    def __init__(self, longest: float, standstill: float) -> None:
        self._longest = longest  # [s] of intervention, 0: without limit
        self._standstill = standstill  # [s] of standing under it, 0: without limit
        self._time = 0.0
        self.reset()

    def reset(self) -> None:
        """Forget the intervention."""
        self._lasted = self._stood = 0.0  # [s]
        self._bar: float | None = None
        self._intervenes = False  # at the last tick

    @property
    def has_ended(self) -> bool:
        """Whether the bar is up."""
        return self._bar is not None

    def bar(self, score: float, threshold: float) -> float:
        """What the score must be above at this tick: its threshold, or more."""
        if score <= threshold:
            self.reset()
            return threshold
        too_long = 0.0 < self._longest <= self._lasted + _TICK or 0.0 < self._standstill <= self._stood + _TICK
        if too_long and self._bar is None:
            self._bar = 0.5 * (score + 1.0)
        return threshold if self._bar is None else self._bar

    def watch(self, scene: Scene, *, intervenes: bool) -> None:
        """Take in whether the command of this tick is replaced."""
        passed = scene.time - self._time if self._intervenes else 0.0
        self._time, self._intervenes = scene.time, intervenes
        if 0.0 < passed <= _PAUSE:
            self._lasted += passed
            self._stood += passed
        if not intervenes or scene.ego.speed >= STANDING:
            self._stood = 0.0
