"""The first moments of a command."""

import sys
import sysconfig

from roadmend.cli import entry


class Interrupting:
    """Stands for a Ctrl-C while modules are imported."""

    @staticmethod
    def find_spec(name, _path=None, _target=None):
        if name == "roadmend.cli.main":
            raise KeyboardInterrupt


def test_an_interrupt_while_it_is_imported_is_a_line_and_130(monkeypatch, capsys):
    monkeypatch.delitem(sys.modules, "roadmend.cli.main", raising=False)
    monkeypatch.setattr(sys, "meta_path", [Interrupting, *sys.meta_path])
    assert entry.main() == 130
    assert capsys.readouterr().err == "roadmend: interrupted\n"


def test_otherwise_it_is_the_command_line(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["roadmend", "--version"])
    assert entry.main() == 0
    assert "roadmend" in capsys.readouterr().out


def test_another_sumo_on_the_path_is_refused_by_name(tmp_path, monkeypatch, capsys):
    (tmp_path / "mine").mkdir()
    monkeypatch.setattr(sys, "argv", ["roadmend", "--version"])
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path / 'mine'}:{sysconfig.get_path('platlib')}")
    assert entry.main() == 0
    (tmp_path / "tools" / "libsumo").mkdir(parents=True)
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path / 'mine'}:{tmp_path / 'tools'}")
    assert entry.main() == 2
    assert f"PYTHONPATH: {tmp_path / 'tools'} has a libsumo" in capsys.readouterr().err
