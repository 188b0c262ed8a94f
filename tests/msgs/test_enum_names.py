"""Numbers that stand for something have their names in a viewer; shown with the viewers' own parser."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from roadmend.core.outcome import Blame, EventKind
from roadmend.core.repair import RepairStatus
from roadmend.core.route import RightOfWay
from roadmend.core.scene import ObjectKind, Signal
from roadmend.recording.definitions import find

TESTS = Path(__file__).parents[1]
NPM = TESTS / "npm"
MESSAGES = sorted((TESTS.parent / "msg" / "msg").glob("*.msg"))
FIELDS = {  # that hold constants: prefix of their names, and the enumeration that they mirror
    "RepairState": {"state": ("", RepairStatus)},
    "ObjectList": {"kind": ("KIND_", ObjectKind), "signal": ("SIGNAL_", Signal)},
    "Route": {"zone_rule": ("RULE_", RightOfWay)},
    "ScenarioEvent": {
        "kind": ("", EventKind),
        "object_kind": ("OBJECT_", ObjectKind),
        "blame": ("BLAME_", Blame),
    },
    "Map": {"lane_kind": ("KIND_", None)},
}


def shown(name):
    """Names by field and number, as a viewer has them for our own part of a message."""
    if shutil.which("node") is None or not (NPM / "node_modules" / "@foxglove" / "rosmsg").is_dir():
        pytest.skip("node or tests/npm/node_modules is not there")
    text = find(f"roadmend_msgs/msg/{name}").text
    done = subprocess.run(
        ["node", "enum_names.mjs"], cwd=NPM, input=text, capture_output=True, text=True, check=True, timeout=60
    )
    return json.loads(done.stdout).get("", {})


@pytest.mark.parametrize("name", [path.stem for path in MESSAGES])
def test_every_constant_is_a_name_of_the_field_that_it_is_for(name):
    found = shown(name)
    assert found.keys() == FIELDS.get(name, {}).keys()
    for field, (prefix, kinds) in FIELDS.get(name, {}).items():
        if kinds is not None:
            assert found[field] == {str(int(kind)): f"{prefix}{kind.name}" for kind in kinds}
        assert all(each.startswith(prefix) for each in found[field].values())


@pytest.mark.parametrize("path", MESSAGES, ids=lambda path: path.stem)
def test_no_constant_is_left_out(path):
    constants = re.findall(r"^uint8 (\w+)=", path.read_text(encoding="utf-8"), re.MULTILINE)
    assert len(constants) == sum(len(names) for names in shown(path.stem).values())
