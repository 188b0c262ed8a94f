"""A node without its extra ends with one line, however it is started."""

import json
import subprocess
import sys

import pytest

from roadmend.core.errors import InputError
from roadmend.nodes.fault import FAULT_FILE, read_fault
from roadmend.nodes.needed import needed

WITHOUT = "import runpy, sys; sys.modules[{library!r}] = None; "
BY_HAND = "runpy.run_module('roadmend.nodes.{node}', run_name='__main__', alter_sys=True)"
AS_SCRIPT = "from roadmend.nodes.{node} import main; sys.exit(main())"


@pytest.mark.parametrize("start", [BY_HAND, AS_SCRIPT], ids=["by hand", "console script"])
@pytest.mark.parametrize(
    ("node", "library", "extra"), [("foxglove", "foxglove", "foxglove"), ("sera", "faiss", "sera")]
)
def test_one_line_names_the_extra(tmp_path, monkeypatch, node, library, extra, start):
    monkeypatch.setenv(FAULT_FILE, str(tmp_path / "fault"))
    code = WITHOUT.format(library=library) + start.format(node=node)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 2, done.stderr
    (line,) = done.stderr.splitlines()
    assert line.startswith(f"roadmend: {library}: needed here and not installed; ")
    assert f"roadmend[{extra}]" in line
    assert isinstance(read_fault(tmp_path / "fault"), InputError)
    assert json.loads((tmp_path / "fault").read_text())["where"] == library


def test_what_no_extra_has_is_broken():
    with pytest.raises(ModuleNotFoundError, match="nothing_of_ours"), needed():
        import nothing_of_ours  # noqa: F401
