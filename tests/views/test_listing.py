"""Literals in their files, with the values that they have now."""

import os
from pathlib import Path
from typing import Any

import pytest

from rosslt_auto.provenance import Source
from rosslt_auto.views import panel
from rosslt_auto.views.listing import Listing, Literal

TEXT = """\
HEIGHT = 1.5
ä = "ö", -2.0  # <b>
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "mission.py"
    path.write_text(TEXT)
    return path


def source(file: Path, line: int, column: int, name: str) -> Source:
    return Source("/node", name, "float", file=str(file), line=line, column=column, text="")


def literal(file: Path, line: int, column: int, name: str, **values: Any) -> Literal:
    return Literal("/node", name, str(file), line, column, "", **values)


@pytest.fixture
def listing(file: Path) -> Listing:
    found = Listing()
    found.source(source(file, 1, 9, "height"), 1.5)
    found.source(source(file, 2, 11, "other"), -2.0)
    return found


def marks(listing: Listing) -> list[str]:
    [one] = listing.files()
    assert one.lines is not None
    return [
        one.lines[line - 1][mark.start : mark.end]
        for line, found in sorted(one.marked.items())
        for mark in found
    ]


def test_literals_are_found_where_they_stand(listing: Listing) -> None:
    assert marks(listing) == ["1.5", "-2.0"]  # columns count bytes, and ä and ö have two


def test_what_matters_is_shown_and_what_has_changed(listing: Listing, file: Path) -> None:
    listing.place(literal(file, 2, 5, "unseen", first="ö", value="ö"))
    assert marks(listing) == ["1.5", "-2.0"]
    listing.value("/node", "unseen", "x")
    assert marks(listing) == ["1.5", '"ö"', "-2.0"]
    assert [one.parameter for one in listing.changed()] == ["unseen"]


def test_a_new_value_is_shown_beside_the_old_text(listing: Listing, file: Path) -> None:
    listing.place(literal(file, 1, 9, "height", first=1.5, value=1.5))
    before = listing.revision
    listing.value("/node", "height", 2.25)
    assert listing.revision > before
    html = panel.code(listing)
    assert '<s>1.5</s><mark class="changed" title="height of /node">2.25</mark>' in html
    assert 'class="live"' in panel.code(listing, {("/node", "height")})


@pytest.mark.parametrize("why", [{"given": "given at start by -p"}, {"in_data": True}])
def test_what_was_given_at_start_or_stands_in_data_is_not_to_be_saved(
    listing: Listing, file: Path, why: dict[str, Any]
) -> None:
    listing.place(literal(file, 1, 9, "height", first=1.5, value=2.25, **why))
    assert listing.changed() == []
    html = panel.code(listing)
    assert 'class="changed"' not in html
    assert ('<mark class="given" title="height of /node, given at start by -p">2.25<' in html) == (
        "given" in why
    )
    rows = [("x", 2.25, "height", [(one, False) for one in listing.literals()])]
    assert ("given at start by -p" in panel.origin("", rows)) == ("given" in why)
    assert ("follows every change" in panel.origin("", rows)) == ("in_data" in why)


def test_nothing_of_a_file_becomes_html(listing: Listing) -> None:
    assert "<b>" not in panel.code(listing)
    assert "&lt;b&gt;" in panel.code(listing)


def test_the_same_news_twice_is_no_news(listing: Listing, file: Path) -> None:
    before = listing.revision
    listing.source(source(file, 1, 9, "height"), 1.5)
    listing.value("/node", "height", 1.5)
    listing.value("/node", "unknown", 1.5)
    assert listing.revision == before


def test_a_changed_file_is_read_again(listing: Listing, file: Path) -> None:
    assert marks(listing) == ["1.5", "-2.0"]
    file.write_text(TEXT.replace("1.5", "12.75"))
    before = listing.revision
    listing.look()
    assert listing.revision > before
    assert marks(listing) == ["12.75", "-2.0"]


@pytest.mark.parametrize("name", ["secret.txt", "missing.py", "binary.py"])
def test_what_is_no_readable_source_file_is_not_read(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    if name != "missing.py":
        path.write_bytes(b"secret = 1.5\xff\xfe\n")
    listing = Listing()
    shown = Source("/node", "p", "float", file=str(path), line=1, column=0, text="x = 1.5")
    listing.source(shown, 1.5)
    [one] = listing.files()
    assert one.lines is None
    assert "secret =" not in panel.code(listing)
    assert "x = 1.5" in panel.code(listing)


def test_an_error_is_marked_until_the_file_changes(listing: Listing, file: Path) -> None:
    trace = f'Traceback:\n  File "{file}", line 2, in mission\nNameError: name <x>\n'
    assert listing.complaint(trace)
    [one] = listing.files()
    assert one.errors == {2: "NameError: name <x>"}
    assert "NameError: name &lt;x&gt;" in panel.code(listing)
    os.utime(file, (1, 1))
    listing.look()
    assert listing.files()[0].errors == {}


def test_errors_elsewhere_are_not_ours(listing: Listing) -> None:
    assert not listing.complaint('File "/usr/lib/python3/json.py", line 2\nValueError: no')
    assert not listing.complaint("no traceback at all")


def test_files_that_drags_change_come_first(listing: Listing, tmp_path: Path) -> None:
    other = tmp_path / "a.py"
    other.write_text("x = 1.0\n")
    listing.source(source(other, 1, 4, "x"), 1.0)
    assert [Path(one.path).name for one in listing.files()] == ["a.py", "mission.py"]
    listing.source(source(tmp_path / "mission.py", 1, 9, "height"), 1.5, weight=2)
    assert [Path(one.path).name for one in listing.files()] == ["mission.py", "a.py"]
    listing.place(literal(other, 1, 4, "x", first=1.0, value=2.0))
    assert [Path(one.path).name for one in listing.files()] == ["a.py", "mission.py"]


def test_nodes_that_let_nobody_change_anything(listing: Listing, file: Path) -> None:
    one = source(file, 1, 9, "height")
    assert not listing.frozen(one)
    listing.place(literal(file, 1, 9, "height", first=1.5, value=1.5, frozen=True))
    assert listing.frozen(one)


def test_nodes_that_are_no_more(listing: Listing, file: Path) -> None:
    listing.ended = {"/node"}
    assert listing.frozen(source(file, 1, 9, "height"))
    listing.ended = set()
    assert not listing.frozen(source(file, 1, 9, "height"))
