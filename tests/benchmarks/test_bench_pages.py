"""The README and the pages say what the committed results say."""

import json
from pathlib import Path

import pytest

from harness.bench_pages import fill, pages
from harness.summary import summary
from roadmend.cli.main import run_group
from roadmend.core.errors import InputError

ROOT = Path(__file__).parents[2]
BENCHMARKS = ROOT / "tests" / "benchmarks"


def test_the_pages_are_up_to_date():
    assert run_group(pages, "pages", ["--root", str(ROOT), "--benchmarks", str(BENCHMARKS), "--check"]) == 0


def test_a_page_that_is_out_of_date_is_told_and_mended(tmp_path):
    (tmp_path / "src" / "doc").mkdir(parents=True)
    (tmp_path / "src" / "doc" / "loop.md").write_text("Before.\n")
    (tmp_path / "README.md").write_text("A\n<!-- figures: loop -->\nold\n<!-- end of figures -->\nB\n")
    words = ["--root", str(tmp_path), "--benchmarks", str(BENCHMARKS)]
    assert run_group(pages, "pages", [*words, "--check"]) == 1
    assert "old" in (tmp_path / "README.md").read_text()
    assert run_group(pages, "pages", words) == 0
    text = (tmp_path / "README.md").read_text()
    assert text.startswith("A\n<!-- figures: loop -->\n| what |")
    assert text.endswith("<!-- end of figures -->\nB\n")
    assert run_group(pages, "pages", [*words, "--check"]) == 0


def test_figures_that_are_not_there_are_an_error():
    with pytest.raises(InputError, match="no such file"):
        fill("<!-- figures: nothing -->\n<!-- end of figures -->", BENCHMARKS)


def test_the_summary_tells_the_committed_figures_with_their_ground():
    rows = summary(BENCHMARKS)
    assert {len(row) for row in rows} == {5}
    content = json.loads((BENCHMARKS / "adreft.json").read_text())
    for policy, methods in content["summary"].items():
        place = next(
            number for number, row in enumerate(rows) if row[0] == "ΔE of ADReFT" and row[1].startswith(policy)
        )
        assert rows[place][2].startswith(f"{methods['adreft']['delta_e']:.1f} at a dose")
        assert f"{methods['adreft']['violations']} persistent violations" in rows[place][1]
        best = float(rows[place + 2][2].split()[0])
        assert all(best >= round(methods[name]["delta_e"], 1) for name in ("rss", "predictive", "rule", "random"))


def test_the_summary_says_whose_fault_its_collisions_are_and_of_how_many_drives():
    told = [row[:3] for row in summary(BENCHMARKS) if row[0].startswith("collisions")]
    content = json.loads((BENCHMARKS / "adreft-ordinary.json").read_text())["ordinary"]["random"]
    assert [place for _, place, _ in told] == [f"{policy} policy, all 1,000 random drives" for policy in content]
    for (what, _, figure), methods in zip(told, content.values(), strict=True):
        own = methods["adreft"]
        assert what == f"collisions by its own fault, {own['collisions_bare']} without repair"
        assert figure == f"{own['collisions']}, {own['new_collisions']} of them new"


def test_the_readme_is_short_and_its_links_lead_somewhere():
    text = (ROOT / "README.md").read_text()
    assert len(text.splitlines()) <= 150
    for page in [ROOT / "README.md", *(ROOT / "src" / "doc").glob("*.md")]:
        for part in page.read_text().split("](")[1:]:
            target = part.split(")")[0].split("#")[0]
            if target and "://" not in target:
                assert (page.parent / target).exists(), f"{page}: {target}"
