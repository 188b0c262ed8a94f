import pytest

from roadmend.measures.need_verdict import NEEDLESS, RESCUE, NeedVerdict, verdict_of


@pytest.mark.parametrize(
    ("need", "verdict"),
    [
        (None, None),
        (0.0, NeedVerdict.NUISANCE),
        (NEEDLESS - 1e-9, NeedVerdict.NUISANCE),
        (NEEDLESS, NeedVerdict.UNCLEAR),
        (RESCUE - 1e-9, NeedVerdict.UNCLEAR),
        (RESCUE, NeedVerdict.RESCUE),
        (1.0, NeedVerdict.RESCUE),
    ],
)
def test_the_verdict_follows_from_the_need(need, verdict):
    assert verdict_of(need) is verdict
