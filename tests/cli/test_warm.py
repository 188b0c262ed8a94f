"""Compiling ahead: everything that can drive is driven, and a missing model stops nothing."""

from roadmend.cli import warm
from roadmend.core.errors import InputError


def test_what_lacks_its_model_is_left_out(monkeypatch, capsys):
    ran = []

    def make(name):
        if name == "learned":
            raise InputError("model", "is missing", "train it")
        return Repairer(name)

    class Repairer:
        def __init__(self, name):
            self.name = name

        def warm_up(self):
            ran.append(("warm-up", self.name))

    monkeypatch.setattr(warm, "METHODS", {"plain": None, "learned": None, "other": None})
    monkeypatch.setattr(warm, "POLICIES", {"driver": None})
    monkeypatch.setattr(warm, "make_policy", lambda name: name)
    monkeypatch.setattr(warm, "make_repairer", make)
    monkeypatch.setattr(warm, "run_episode", lambda scenario, _, repairer: ran.append((scenario.family, repairer.name)))
    warm.main()
    wanted = [[("warm-up", name), ("S1", name), ("S5", name)] for name in ("plain", "other")]
    assert ran == [*wanted[0], *wanted[1]]
    assert capsys.readouterr().err == "driver with learned left out: model: is missing; train it\n"
