from harness import adreft_cost
from harness.contenders import Contender
from harness.repair_cost import gather_moments


def test_every_method_but_the_bound_is_timed_on_the_same_frames(monkeypatch):
    asked = []

    def gather(policy, objects, ticks):
        asked.append((policy, objects))
        return gather_moments(policy, objects, 2)

    monkeypatch.setattr(adreft_cost, "gather_moments", gather)
    contenders = [
        Contender("none", "no repair", "reference", "modular", "none"),
        Contender("predictive", "PredictiveBrake", "rival", "modular", "predictive", {"adaptive": False}),
        Contender("hindsight", "hindsight bound", "bound", "modular", "hindsight"),
    ]
    cost = adreft_cost.cost_of(contenders, is_quick=True)
    assert asked == [("modular", 20)]
    assert [*cost] == ["none", "predictive"]
    for figures in cost.values():
        assert 0.0 < figures["median_ms"] <= figures["p99_ms"]
    assert adreft_cost.cost_of(contenders[2:]) == {}
