from roadmend.core.source_digest import meaning, source_digest

CODE = '''
"""Says something."""

def add(a, b):
    """Adds."""
    return a + b  # of course
'''


def test_comments_docstrings_and_layout_do_not_count_but_code_does():
    same = "def add(a,\n        b):\n    return (a + b)\n"
    assert meaning(CODE) == meaning(same)
    assert meaning(CODE) != meaning(CODE.replace("a + b", "a - b"))


def test_only_what_is_imported_counts():
    rule = source_digest(["roadmend.repair.rule"])
    assert rule == source_digest(["roadmend.repair.rule"])
    assert rule == source_digest(["roadmend.repair.rule", "roadmend.repair.actions", "roadmend.repair.registry"])
    assert rule != source_digest(["roadmend.repair.rule", "roadmend.repair.rss"])


def test_another_package_is_followed_into_roadmend(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    package = tmp_path / "stranger"
    package.mkdir()
    (package / "__init__.py").touch()
    (package / "policy.py").write_text("import json\nfrom stranger.helper import help_out\n")
    (package / "helper.py").write_text("from roadmend.repair.rule import RuleRepair\n")
    digests = {source_digest(["stranger.policy"]), source_digest(["stranger.helper"])}
    assert not digests & {source_digest(["roadmend.repair.rule"])}
    assert len(digests) == 2
