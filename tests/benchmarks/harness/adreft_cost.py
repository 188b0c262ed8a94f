"""What one frame costs under every method of the benchmark, plain PyTorch beside them."""

from collections.abc import Callable, Sequence
from functools import partial

from harness.contenders import Contender
from harness.repair_cost import gather_moments, measure_cost
from roadmend.core.interfaces import Repairer
from roadmend.repair.adreft.method import AdreftRepair
from roadmend.repair.method import RepairMethod
from roadmend.repair.registry import make_repairer

EAGER = "torch_eager"
OBJECTS = 20
_ROUNDS = 3
_TICKS = 100  # of each family


def cost_of(contenders: Sequence[Contender], *, is_quick: bool = False) -> dict[str, dict[str, float]]:
    """Milliseconds a frame, by method; "ratio" is to ADReFT's model in plain PyTorch where torch is installed.

    Raises:
        InputError: a model is unusable.
    """
    timed = [contender for contender in contenders if contender.group != "bound"]
    if not timed:
        return {}
    makers: dict[str, Callable[[], RepairMethod | Repairer]] = {
        contender.name: partial(make_repairer, contender.method, contender.parameters) for contender in timed
    }
    eager = next((_eager(contender) for contender in timed if contender.name == "adreft"), None)
    if eager is not None:
        makers[EAGER] = eager
    moments = gather_moments(timed[0].policy, OBJECTS, _TICKS // 4 if is_quick else _TICKS)
    return measure_cost(makers, moments, 1 if is_quick else _ROUNDS, EAGER if eager is not None else None)


def _eager(contender: Contender) -> Callable[[], RepairMethod] | None:
    """The same model, run by plain PyTorch; None where torch is not installed."""
    try:
        from harness.eager_model import EagerAdreftModel
    except ImportError:
        return None
    assert contender.model is not None
    path = contender.model
    return lambda: AdreftRepair(model=EagerAdreftModel.load(path))
