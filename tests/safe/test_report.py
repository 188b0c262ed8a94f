"""Reports on disk, whole and broken."""

import errno
import io
from pathlib import Path

import pytest
from PIL import Image

from roadmend.core.errors import InputError
from roadmend.core.whole_file import write_text
from roadmend.safe.cases import gather_cases
from roadmend.safe.report import MAX_SUMMARY, find_reports, load_report, report_of_text


def png(size=(8, 8)):
    data = io.BytesIO()
    Image.new("RGB", size, "white").save(data, "png")
    return data.getvalue()


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "case").mkdir()
    (tmp_path / "case" / "summary.txt").write_text("V1 hit V2.")
    return tmp_path / "case"


def test_a_report_with_a_sketch(folder):
    (folder / "sketch.png").write_bytes(png())
    report = load_report(folder)
    assert (report.case, report.summary, report.notes) == ("case", "V1 hit V2.", ())
    assert report.sketch.media_type == "image/png"
    assert report.digest() != load_report(folder / "summary.txt").digest()


@pytest.mark.parametrize("data", [b"", b"no image", png()[:40], b"\x89PNG\r\n\x1a\n" + bytes(30)])
def test_an_image_that_is_none_is_left_out_and_said(folder, data):
    (folder / "sketch.jpg").write_bytes(data)
    report = load_report(folder)
    assert report.sketch is None
    assert "sketch.jpg is no image" in report.notes[0]


def test_a_sketch_that_unpacks_to_gigabytes_is_left_out(folder, monkeypatch):
    monkeypatch.setattr(Image, "MAX_IMAGE_PIXELS", 10)
    (folder / "sketch.png").write_bytes(png())
    assert load_report(folder).sketch is None


def test_no_sketch_is_said(folder):
    assert load_report(folder).notes == ("the report has no sketch",)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "is empty"),
        (b" \n\t ", "is empty"),
        (bytes(range(256)), "is no text"),
        (b"\x7fELF\x02\x01\x01\x00", "is no text"),
        (b"V1 hit V2. " * 1_000_000, "is longer than"),
        ("\u00e9".encode() * 200_000, "is longer than"),
    ],
    ids=["empty", "blank", "binary", "program", "10 MB", "two-byte characters"],
)
def test_summaries_that_are_none(tmp_path, content, complaint):
    (tmp_path / "case.txt").write_bytes(content)
    with pytest.raises(InputError, match=complaint):
        load_report(tmp_path / "case.txt")


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be"])
def test_a_text_as_windows_saves_unicode(tmp_path, encoding):
    file = tmp_path / "a.txt"
    mark = "" if encoding == "utf-16" else "\ufeff"
    file.write_bytes((mark + "V1 went north at 25 mph, V1\u2019s limit, and hit V2.").encode(encoding))
    assert load_report(file).summary == "V1 went north at 25 mph, V1\u2019s limit, and hit V2."
    file.write_bytes(b"\xff\xfe\x00\x00\x01\x00" * 20)
    with pytest.raises(InputError, match="is no text"):
        load_report(file)


def test_old_encodings_and_marks(tmp_path):
    (tmp_path / "old.txt").write_bytes("V1\x92s front".encode("latin-1"))
    (tmp_path / "mark.txt").write_bytes(b"\xef\xbb\xbfV1")
    assert load_report(tmp_path / "old.txt").summary == "V1\u2019s front"
    assert load_report(tmp_path / "mark.txt").summary == "V1"
    (tmp_path / "most.txt").write_text("x" * MAX_SUMMARY)
    assert len(load_report(tmp_path / "most.txt").summary) == MAX_SUMMARY


def test_finding_reports(folder):
    (folder.parent / "other.txt").write_text("x")
    (folder.parent / "notes.md").write_text("x")
    (folder.parent / "empty").mkdir()
    assert [path.name for path in find_reports(folder.parent)] == ["case", "other.txt"]
    assert find_reports(folder) == (folder,)
    assert [path.name for path in find_reports(folder.parent / "other.txt", folder)] == ["other.txt", "case"]
    with pytest.raises(InputError, match=r"case: has the name of .*case; rename one of them"):
        find_reports(folder, folder.parent)
    assert find_reports(folder.parent / "other.txt") == (folder.parent / "other.txt",)


def test_a_folder_that_may_not_be_read_is_named(folder, monkeypatch):
    closed = folder.parent / "closed"
    closed.mkdir()
    is_file, listed = Path.is_file, Path.iterdir

    def refused(path):
        raise PermissionError(errno.EACCES, "Permission denied", str(path))

    # As root, which may read everything, no folder would do.
    monkeypatch.setattr(Path, "iterdir", lambda path: refused(path) if path == closed else listed(path))
    complaint = r"closed: cannot be read \(Permission denied\); make it readable"
    for call in (find_reports, load_report, lambda path: gather_cases([path])):
        with pytest.raises(InputError, match=complaint):
            call(closed)
    for call in (find_reports, lambda path: gather_cases([path])):
        with pytest.raises(InputError, match=complaint):
            call(folder.parent)
    monkeypatch.setattr(Path, "iterdir", listed)
    monkeypatch.setattr(Path, "is_file", lambda path: refused(path) if path.parent == folder else is_file(path))
    with pytest.raises(InputError, match=r"summary.txt: cannot be read"):  # one may list it and go no further
        find_reports(folder.parent)


def test_no_reports(folder):
    with pytest.raises(InputError, match="no such report"):
        find_reports(folder / "missing")
    (folder.parent / "empty").mkdir()
    with pytest.raises(InputError, match="holds no report"):
        find_reports(folder.parent / "empty")
    with pytest.raises(InputError, match="has no summary"):
        load_report(folder.parent / "empty")
    (folder.parent / "case.txt").write_text("x")
    with pytest.raises(InputError, match=r"case.txt: has the name of .*case; rename one of them"):
        find_reports(folder.parent)


def test_a_name_that_belongs_to_the_files_of_another_report_is_refused(tmp_path):
    for name in ("a.txt", "a.evidence.txt"):
        (tmp_path / name).write_text("V1 hit V2.")
    with pytest.raises(InputError, match=r"a\.evidence\.txt: has a name that ends in \.evidence, .*; rename it"):
        find_reports(tmp_path)
    with pytest.raises(InputError, match="cannot be a file's"):
        report_of_text("a.evidence", "V1 hit V2.")


@pytest.mark.parametrize("letter", ["l", "\u0436"])
def test_a_name_too_long_for_the_files_that_go_by_it_is_the_reports_own_fault(letter, tmp_path):
    letters = 200 // len(letter.encode())
    (tmp_path / f"{letter * letters}.txt").write_text("V1 hit V2.")
    (path,) = find_reports(tmp_path)
    write_text(tmp_path / f"{load_report(path).case}-onlooker-reproduced-modular.yaml", "")
    longer = path.rename(path.with_stem(letter * (letters + 1)))
    with pytest.raises(InputError, match="has a name of more than 200 bytes; rename it"):
        load_report(longer)
