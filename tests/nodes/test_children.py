"""Node processes: each starts in the environment of the moment, however old the server is that forks it."""

import json

import pytest

from roadmend.nodes.children import Child

MODULE = """
import json, os

def main(arguments):
    print(json.dumps({name: value for name, value in os.environ.items() if name.startswith("ROADMEND_TEST")}))
    return 0
"""


@pytest.fixture
def told(tmp_path, monkeypatch):
    """Starts a child that prints its environment, and reads what it printed."""
    (tmp_path / "tells_its_environment.py").write_text(MODULE)
    monkeypatch.syspath_prepend(tmp_path)

    def start(environment):
        log = tmp_path / "log"
        log.unlink(missing_ok=True)
        child = Child("teller", "tells_its_environment", [], environment, log, may_restart=False)
        child.start()
        child.process.join(60.0)
        assert child.exit_code == 0, log.read_text()
        return json.loads(log.read_text())

    return start


def test_a_child_sees_the_environment_as_it_is_and_not_as_it_was(told, monkeypatch):
    monkeypatch.setenv("ROADMEND_TEST_DOMAIN", "1")
    assert told({}) == {"ROADMEND_TEST_DOMAIN": "1"}
    monkeypatch.setenv("ROADMEND_TEST_DOMAIN", "2")
    assert told({}) == {"ROADMEND_TEST_DOMAIN": "2"}
    assert told({"ROADMEND_TEST_DOMAIN": "3"}) == {"ROADMEND_TEST_DOMAIN": "3"}
    monkeypatch.delenv("ROADMEND_TEST_DOMAIN")
    assert told({"ROADMEND_TEST_OWN": "4"}) == {"ROADMEND_TEST_OWN": "4"}
