"""Every method of the plan can be drawn."""

from harness.chart_labels import GROUP_COLOUR, GROUP_TITLE, colour_of, group_handles
from harness.contenders import read_plan
from harness.options import PLANS


def test_every_group_of_the_plan_has_a_colour_and_a_name_of_its_own():
    methods = read_plan(PLANS / "adreft.yaml").methods
    content = {"titles": {name: {"title": method.title, "group": method.group} for name, method in methods.items()}}
    groups = {method.group for method in methods.values()}
    assert {colour_of(content, name) for name in methods} == {GROUP_COLOUR[group] for group in groups}
    assert {handle.get_label() for handle in group_handles(content, [*methods])} == {
        GROUP_TITLE[group] for group in groups
    }
    assert len(set(GROUP_COLOUR.values())) == len(GROUP_COLOUR)
