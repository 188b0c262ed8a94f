"""The page of a crash report: what stands on it, and what its script does in a browser where there is one."""

import json
import shutil
import subprocess
from dataclasses import asdict
from html.parser import HTMLParser

import pytest

from roadmend.core.errors import InputError
from roadmend.language.chat import Image
from roadmend.reports.crash_page import CrashAccount, account_of_case, load_account, page_of_crash
from roadmend.safe.cases import CrashCase
from roadmend.safe.embedded import EmbeddedExtractor
from roadmend.safe.extraction_run import keep_extraction
from roadmend.safe.report import CrashReport
from roadmend.safe.sketch_claims import SketchClaims
from tests.safe.crashes import crash, vehicle

SUMMARY = (
    "V1, a 2012 Honda Civic, was traveling north on a straight two-lane road. V2, a 2001 Ford F-150, was traveling "
    "south. It was <daylight> and raining. V1 crossed the centerline and its front struck the front of V2."
)
FILM = {
    "scenario": "case-v1-0",
    "text": "the ego and v2 collided",
    "collided": True,
    "vehicles": [{"name": "v1", "length": 4.5, "width": 1.8}, {"name": "v2", "length": 5.0, "width": 2.0}],
    "frames": [
        [0.0, [[0.0, 0.0, 1.57], [0.0, 60.0, -1.57]]],
        [0.1, [[0.0, 1.0, 1.57], None]],
        [0.2, [[0.0, 25.0, 1.57], [0.0, 30.0, -1.57]]],
    ],
    "lanes": [{"kind": "road", "width": 3.2, "points": [[0.0, -50.0], [0.0, 100.0]]}],
}
BROWSER = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


def extraction():
    reader = EmbeddedExtractor(lambda _sketch, _cast: SketchClaims((), "read: nothing"))
    return reader.extract(CrashReport("case", SUMMARY, Image(b"no picture", "image/png")))


def account(**changes):
    found = extraction()
    fields = {name: asdict(evidence) for name, evidence in found.evidence.items()}
    return CrashAccount(
        **{"case": "case", "summary": SUMMARY, "sketch": None, "fields": fields, "sketch_note": "there is none"}
        | changes
    )


class Elements(HTMLParser):
    def __init__(self, page):
        super().__init__()
        self.found, self.texts, self._open = [], {}, None
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.found.append((tag, dict(attributes)))
        self._open = dict(attributes).get("data-fields") if tag == "span" else None

    def handle_data(self, data):
        if self._open:
            self.texts[self._open] = self.texts.get(self._open, "") + data

    def handle_endtag(self, tag):
        self._open = None


def test_phrases_point_at_their_fields_and_the_text_stays_text():
    page = page_of_crash(account())
    phrases = Elements(page).texts
    assert any("north" in text for fields, text in phrases.items() if "vehicles[0].initial_position" in fields.split())
    assert "&lt;daylight&gt;" in page or "&lt;" in page
    assert "<daylight>" not in page


def test_every_field_has_its_row():
    rows = [
        each["data-field"]
        for tag, each in Elements(page_of_crash(account())).found
        if tag == "tr" and "data-field" in each
    ]
    assert rows == list(extraction().evidence)


def test_doubts_and_gaps_are_named():
    fields = {
        "road_type": {"value": "Curve", "confidence": 0.5, "reason": "r", "doubts": ("second reading: Straight",)},
        "num_lanes": {"value": None, "confidence": 0.0, "reason": "the report does not say", "doubts": ()},
        "env.time": {"value": "Daytime", "confidence": 0.97, "reason": "r", "doubts": ()},
    }
    page = page_of_crash(account(fields=fields, notes=("road_type is in doubt: Curve", "a deer takes part")))
    doubts = page[page.index("In doubt") : page.index("Every field")]
    assert "Curve with confidence 0.50 only" in doubts
    assert "second reading: Straight" in doubts
    assert "left open: <code>num_lanes</code>" in doubts
    assert "a deer takes part" in doubts
    assert "road_type is in doubt" not in doubts  # said once
    assert "env.time" not in doubts


def test_without_doubts_it_says_so():
    fields = {"road_type": {"value": "Curve", "confidence": 0.95, "reason": "r"}}
    assert "Nothing: every field was read" in page_of_crash(account(fields=fields))


def test_a_sketch_that_cannot_be_read_is_shown_as_it_is():
    page = page_of_crash(account(sketch=Image(b"no picture", "image/png"), sketch_note="not read: why"))
    assert 'src="data:image/png;base64,bm8gcGljdHVyZQ=="' in page
    assert "not read: why" in page


def test_a_sketch_that_was_read_has_that_drawn_over_it():
    pytest.importorskip("cv2", reason="needs the extra sketch")
    from tests.safe.sketch.drawings import RED, Drawing

    sketch = Drawing().vehicle(300, 300, 0, RED, "V1").sketch()
    page = page_of_crash(account(sketch=sketch))
    assert "sketch with what was read of it" in page


def test_a_case_without_its_report_shows_what_its_file_states():
    case = CrashCase("head-on", crash("Straight", vehicle("W2E"), vehicle("E2W")))
    page = page_of_crash(account_of_case(case, []))
    assert "The text of the report is not at hand." in page
    assert "the file states it" in page
    assert "No scene is shown." in page


def test_the_account_of_a_kept_extraction_is_that_of_a_fresh_one(tmp_path):
    found = extraction()
    keep_extraction(found, "case", "key", tmp_path)
    report = CrashReport("case", SUMMARY)
    kept = page_of_crash(load_account(report, tmp_path, []))
    fresh = page_of_crash(account(sketch_note=found.sketch, notes=found.notes))
    assert kept == fresh


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        '{"fields": 3, "sketch": "", "notes": []}',
        '{"fields": {}, "sketch": "", "notes": [3]}',
        *(
            f'{{"fields": {{"road_type": {{"value": "Curve", "confidence": 0.5, {changed}}}}}, "sketch": "", "notes": []}}'
            for changed in ('"reason": 1', '"reason": "", "span": [1]', '"reason": "", "doubts": "none"')
        ),
        '{"fields": {"road_type": {"value": "Curve", "confidence": "high"}}, "sketch": "", "notes": []}',
    ],
)
def test_a_broken_evidence_file_is_one_line(tmp_path, text):
    (tmp_path / "case.evidence.json").write_text(text)
    with pytest.raises(InputError, match=r"case\.evidence\.json"):
        load_account(CrashReport("case", SUMMARY), tmp_path, [])


def test_the_page_asks_for_nothing_from_elsewhere():
    page = page_of_crash(account(films=[FILM]))
    assert "://" not in page


@pytest.mark.skipif(BROWSER is None, reason="no browser is installed")
def test_in_a_browser_the_run_plays_to_the_contact_and_phrases_find_their_rows(tmp_path):
    page = page_of_crash(account(films=[FILM, {**FILM, "scenario": "case-v2-0", "text": "as built"}]))
    script = """<script>
    const result = {};
    window.onerror = (message) => { result.error = message; };
    addEventListener("load", () => {
      result.begin = document.getElementById("now").textContent;
      document.getElementById("end").click();
      result.end = document.getElementById("now").textContent;
      const film = document.getElementById("film");
      film.value = "1";
      film.dispatchEvent(new Event("change"));
      result.other = document.getElementById("ending").textContent;
      document.querySelector('[data-fields~="vehicles[0].initial_position"]').click();
      result.chosen = [...document.querySelectorAll("tr.chosen")].map((row) => row.dataset.field);
      const row = document.querySelector('tr[data-field="env.weather"]');
      row.focus();
      result.focused = document.activeElement === row;
      row.dispatchEvent(new KeyboardEvent("keydown", { key: "Enter", bubbles: true }));
      result.by_key = [...document.querySelectorAll("tr.chosen")].map((row) => row.dataset.field);
      const pixels = document.getElementById("scene").getContext("2d").getImageData(0, 0, 1200, 620).data;
      result.drawn = new Set(pixels).size > 8;
      document.body.dataset.result = JSON.stringify(result);
    });
    </script></body>"""
    file = tmp_path / "page.html"
    file.write_text(page.replace("</body>", script), encoding="utf-8")
    command = [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=4000", "--dump-dom"]
    done = subprocess.run(
        [*command, f"--user-data-dir={tmp_path / 'profile'}", file.as_uri()],
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    (body,) = [each for tag, each in Elements(done.stdout).found if tag == "body"]
    result = json.loads(body["data-result"])
    assert result["begin"] == "0.0 s"
    assert result["end"] == "0.2 s, contact"
    assert result["other"] == "case-v2-0: as built"
    assert "vehicles[0].initial_position" in result["chosen"]
    assert result["focused"]
    assert result["by_key"] == ["env.weather"]
    assert result["drawn"]
    assert "error" not in result
