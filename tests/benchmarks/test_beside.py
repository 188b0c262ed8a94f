"""What other commands measured is taken into adreft.json, on a copy of the committed results."""

import json
import shutil
from pathlib import Path

from harness.beside import beside, renew

COMMITTED = Path(__file__).parent


def test_what_has_changed_beside_it_is_in_the_file_that_programs_read(tmp_path):
    for path in COMMITTED.glob("adreft*.json"):
        shutil.copy(path, tmp_path / path.name)
    ordinary = json.loads((tmp_path / "adreft-ordinary.json").read_text())
    ordinary["ordinary"] = {"random": {"modular": {}, "neural": {}}}
    (tmp_path / "adreft-ordinary.json").write_text(json.dumps(ordinary))
    before = json.loads((tmp_path / "adreft.json").read_text())
    renew(tmp_path)
    after = json.loads((tmp_path / "adreft.json").read_text())
    assert after["ordinary"] == ordinary["ordinary"]
    assert {key: after[key] for key in before if key not in beside(tmp_path)} == {
        key: value for key, value in before.items() if key not in beside(tmp_path)
    }
    assert "by rollouts" in (tmp_path / "adreft-tables.md").read_text()


def test_a_folder_without_the_main_results_stays_as_it_is(tmp_path):
    renew(tmp_path)
    assert not list(tmp_path.iterdir())
