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
