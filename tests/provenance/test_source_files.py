"""Ranges of files are replaced, and nothing else is."""

import ast
import os
import stat

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosslt_auto.provenance.source_files import Edit, NotWritten, SourceFile

CONTENTS = {
    "plain": b"x = 1\ny = 2.5\n",
    "no newline at the end": b"x = 1\ny = 2.5",
    "crlf": b"x = 1\r\ny = 2.5  # c\r\n",
    "cr": b"x = 1\ry = 2.5\r",
    "tabs": b"if 1:\n\tx = 1\n\ty = '\t', 2.5\n",
    "bom": b"\xef\xbb\xbfx = 1; y = 2.5\n",
    "utf-8": "s = 'häß 🚁'; x = 1; y = 2.5\n".encode(),
    "latin-1": "# -*- coding: latin-1 -*-\ns = 'häß'; x = 1; y = 2.5\n".encode("latin-1"),
    "form feed": b"x = 1\n\x0c\ny = 2.5\n\x0cz = 3\n",
    "separators": "s = 'a\u2028b\x85c\x1cd'; x = 1\ny = 2.5\n".encode(),
    "several lines": b"x = (1 +\n  'ab'\n  'c', 2.5)\n",
}


def constants(tree):
    found = [node for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    return [node for node in found if type(node.value) in (int, float)]


@pytest.mark.parametrize("content", CONTENTS.values(), ids=CONTENTS)
def test_positions_of_the_ast_are_ranges_of_the_text(content, tmp_path):
    file = SourceFile("x.py", content)
    nodes = constants(ast.parse(content))
    assert nodes
    for node in nodes:
        start, end = file.range(node.lineno, node.col_offset, node.end_lineno, node.end_col_offset)
        assert file.text[start:end] == repr(node.value)
        assert file.position(start) == (node.lineno, node.col_offset)
        assert repr(node.value) in file.line(node.lineno)


@pytest.mark.parametrize("content", CONTENTS.values(), ids=CONTENTS)
def test_everything_else_stays_byte_for_byte(content, tmp_path):
    path = tmp_path / "x.py"
    path.write_bytes(content)
    path.chmod(0o640)
    file = SourceFile(str(path), content)
    edits = []
    for node in constants(ast.parse(content)):
        where = file.range(node.lineno, node.col_offset, node.end_lineno, node.end_col_offset)
        edits.append(Edit(*where, f"1000{node.value!r}"))
    edits.reverse()
    written = file.write(edits)
    now = path.read_bytes()
    assert now == written.content
    assert now.replace(b"1000", b"") == content
    assert len(now) == len(content) + 4 * len(edits)
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert os.listdir(tmp_path) == ["x.py"]


@given(st.text(max_size=40), st.data())
def test_edits_are_those_of_the_text(text, data):
    file = SourceFile("f", text.encode(), "utf-8")
    cuts = sorted(data.draw(st.lists(st.integers(0, len(file.text)), max_size=6)))
    cuts = cuts[: len(cuts) // 2 * 2]
    edits = [Edit(a, b, "new") for a, b in zip(cuts[::2], cuts[1::2], strict=True)]
    expected, at = "", 0
    for edit in edits:
        expected += file.text[at : edit.start] + "new"
        at = edit.end
    assert file.edited(edits).text == expected + file.text[at:]


def test_a_changed_file_is_refused_and_says_where(tmp_path):
    path = tmp_path / "x.py"
    path.write_bytes(b"a\nb\nc\nd\n")
    file = SourceFile(str(path), b"a\nb\nc\nd\n")
    path.write_bytes(b"a\nB\nc\nD\ne\n")
    with pytest.raises(NotWritten, match=r"lines 2, 4-5 differ"):
        file.write([Edit(0, 1, "x")])
    assert path.read_bytes() == b"a\nB\nc\nD\ne\n"
    path.unlink()
    with pytest.raises(NotWritten, match="No such file"):
        file.write([Edit(0, 1, "x")])
    assert os.listdir(tmp_path) == []


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "real").mkdir()
    real, link = tmp_path / "real" / "x.py", tmp_path / "link.py"
    real.write_bytes(b"x = 1\n")
    link.symlink_to("real/x.py")
    SourceFile(str(link), b"x = 1\n").write([Edit(4, 5, "2")])
    assert link.is_symlink() and real.read_bytes() == b"x = 2\n"


def test_what_fails_on_the_way_leaves_everything_as_it_was(tmp_path, monkeypatch):
    path = tmp_path / "x.py"
    path.write_bytes(b"x = 1\n")

    def fail(*paths):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(NotWritten, match="No space left"):
        SourceFile(str(path), b"x = 1\n").write([Edit(4, 5, "2")])
    assert path.read_bytes() == b"x = 1\n" and os.listdir(tmp_path) == ["x.py"]


def test_a_change_while_writing_is_noticed(tmp_path, monkeypatch):
    path = tmp_path / "x.py"
    path.write_bytes(b"x = 1\n")
    fsync = os.fsync

    def meanwhile(descriptor):
        path.write_bytes(b"x = 5\n")
        fsync(descriptor)

    monkeypatch.setattr(os, "fsync", meanwhile)
    with pytest.raises(NotWritten, match="line 1 differs"):
        SourceFile(str(path), b"x = 1\n").write([Edit(4, 5, "2")])
    assert path.read_bytes() == b"x = 5\n" and os.listdir(tmp_path) == ["x.py"]


def test_a_cached_compilation_does_not_outlive_the_change(tmp_path):
    path = tmp_path / "x.py"
    path.write_bytes(b"x = 1\n")
    before = path.stat().st_mtime
    SourceFile(str(path), b"x = 1\n").write([Edit(4, 5, "2")])
    assert int(path.stat().st_mtime) > int(before)


def test_a_folder_and_strange_encodings_are_refused(tmp_path):
    with pytest.raises(NotWritten, match="no regular file"):
        SourceFile(str(tmp_path), b"").write([Edit(0, 0, "x")])
    with pytest.raises(NotWritten):
        SourceFile("x", b"\xff")
    with pytest.raises(NotWritten):
        SourceFile("x", b"# coding: nonsense\n")
    with pytest.raises(NotWritten):
        SourceFile("x", b"# coding: ascii\nx").edited([Edit(16, 17, "é")])


def test_wrong_edits_are_errors():
    file = SourceFile("x", b"abc")
    for edits in ([Edit(0, 2, ""), Edit(1, 3, "")], [Edit(0, 9, "")], [Edit(2, 1, "")]):
        with pytest.raises(ValueError, match="overlap"):
            file.edited(edits)
    for line, column in ((0, 0), (2, 0), (1, 9)):
        with pytest.raises(ValueError, match="has no"):
            file.offset(line, column)


def test_a_diff_writes_nothing(tmp_path):
    path = tmp_path / "x.py"
    path.write_bytes(b"x = 1\ny = 2")
    file = SourceFile(str(path), path.read_bytes())
    assert file.diff([Edit(10, 11, "3")]) == (
        f"--- {path}\n+++ {path}\n@@ -1,2 +1,2 @@\n x = 1\n-y = 2\n\\ No newline at end of file\n"
        "+y = 3\n\\ No newline at end of file\n"
    )
    assert path.read_bytes() == b"x = 1\ny = 2"
