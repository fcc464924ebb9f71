"""Changing ranges of a text file, and nothing else of it.

A file is changed only while it is, byte for byte, the one that was loaded, and in one step: a new
file takes its place, so that whoever reads it meets the old content or the new one.
"""

from __future__ import annotations

import bisect
import contextlib
import difflib
import io
import os
import re
import stat
import tempfile
import tokenize
from collections.abc import Iterable
from typing import NamedTuple


class Edit(NamedTuple):
    """`text` in place of the characters from `start` to before `end` (offsets in the text)."""

    start: int
    end: int
    text: str


class NotWritten(Exception):
    """A file was not changed, and nothing else was either; the message says why."""


class SourceFile:
    """A text file as it was when it was loaded.

    path      where it is; a symbolic link stays one, the file that it points to is changed
    content   the bytes that were loaded
    encoding  None: as Python finds it (a BOM, a coding line, UTF-8)
    text      the characters, line ends as they stand in the file

    Raises NotWritten if the content has no such encoding.
    """

    def __init__(self, path: str, content: bytes, encoding: str | None = None) -> None:
        self.path = path
        self.content = content
        try:
            self.encoding = encoding or tokenize.detect_encoding(io.BytesIO(content).readline)[0]
            self.text = content.decode(self.encoding)
            exact = self.text.encode(self.encoding) == content
        except (SyntaxError, UnicodeError, LookupError) as error:
            raise NotWritten(f"{path}: {error}") from None
        if not exact:
            raise NotWritten(f"{path}: its encoding {self.encoding} has several ways to say this")
        self._starts = _line_starts(self.text)

    # ------------------------------------------------------------ positions

    def offset(self, line: int, column: int) -> int:
        """The offset of a position of Python's ast: line from 1, column in bytes of UTF-8."""
        if not 1 <= line <= len(self._starts):
            raise ValueError(f"{self.path} has no line {line}")
        start, end = self._span(line)
        before = self.text[start:end].encode("utf-8")[:column]
        if len(before) < column:
            raise ValueError(f"{self.path} has no column {column} in line {line}")
        return start + len(before.decode("utf-8"))

    def range(self, line: int, column: int, end_line: int, end_column: int) -> tuple[int, int]:
        """The offsets of a node of Python's ast."""
        return self.offset(line, column), self.offset(end_line, end_column)

    def position(self, offset: int) -> tuple[int, int]:
        """The position of Python's ast, line and column, of an offset: what `offset` undoes."""
        line = bisect.bisect_right(self._starts, offset)
        return line, len(self.text[self._starts[line - 1] : offset].encode("utf-8"))

    def line(self, number: int) -> str:
        """A line, counted from 1, without what surrounds its text."""
        return self.text[slice(*self._span(number))].strip()

    def _span(self, line: int) -> tuple[int, int]:
        end = self._starts[line] if line < len(self._starts) else len(self.text)
        return self._starts[line - 1], end

    # ------------------------------------------------------------ edits

    def edited(self, edits: Iterable[Edit]) -> SourceFile:
        """The file as `edits` make it; nothing is written.

        Raises ValueError if edits overlap, NotWritten if the file's encoding lacks a character.
        """
        parts: list[str] = []
        at = 0
        for edit in sorted(edits):
            if not at <= edit.start <= edit.end <= len(self.text):
                raise ValueError(f"edits of {self.path} overlap or lie outside of it")
            parts += (self.text[at : edit.start], edit.text)
            at = edit.end
        text = "".join((*parts, self.text[at:]))
        try:
            content = text.encode(self.encoding)
        except UnicodeEncodeError as error:
            raise NotWritten(f"{self.path}: {error}") from None
        return SourceFile(self.path, content, self.encoding)

    def diff(self, edits: Iterable[Edit]) -> str:
        """What `edits` change, as a unified diff."""
        return "".join(
            line if line.endswith("\n") else f"{line}\n\\ No newline at end of file\n"
            for line in difflib.unified_diff(
                _lines(self.text), _lines(self.edited(edits).text), self.path, self.path
            )
        )

    def now(self) -> bytes:
        """What is in the file now. Raises NotWritten if it cannot be read."""
        path = os.path.realpath(self.path)
        try:
            if not stat.S_ISREG(os.stat(path).st_mode):
                raise NotWritten(f"{self.path} is no regular file")
            with open(path, "rb") as file:
                return file.read()
        except OSError as error:
            raise NotWritten(f"{self.path}: {error.strerror}") from None

    def verify(self) -> None:
        """Raises NotWritten unless the file is what was loaded, and can be replaced."""
        now = self.now()
        if now != self.content:
            raise NotWritten(f"{self.path} is not what was loaded: {self._differing(now)}")
        path = os.path.realpath(self.path)
        if not (os.access(path, os.W_OK) and os.access(os.path.dirname(path), os.W_OK)):
            raise NotWritten(f"{self.path} cannot be written here")

    def write(self, edits: Iterable[Edit]) -> SourceFile:
        """Writes `edits` and returns the file as it is then.

        Raises NotWritten, the file untouched.
        """
        new = self.edited(edits)
        if new.content != self.content:
            self.verify()
            try:
                self._replace(new.content)
            except OSError as error:
                raise NotWritten(f"{self.path}: {error.strerror}") from None
        return new

    def _replace(self, content: bytes) -> None:
        path = os.path.realpath(self.path)
        folder, name = os.path.split(path)
        before = os.stat(path)
        descriptor, temporary = tempfile.mkstemp(prefix=f".{name}.", suffix="~", dir=folder)
        try:
            with open(descriptor, "wb") as file:
                file.write(content)
                file.flush()
                with contextlib.suppress(OSError):  # only root may give files away
                    os.fchown(file.fileno(), before.st_uid, before.st_gid)
                os.fchmod(file.fileno(), stat.S_IMODE(before.st_mode))
                os.fsync(file.fileno())
            _make_newer(temporary, before)
            self.verify()  # once more: writing has taken its time
            os.replace(temporary, path)
        except BaseException:
            with contextlib.suppress(OSError):
                os.unlink(temporary)
            raise
        _sync_folder(folder)

    def _differing(self, now: bytes) -> str:
        """The lines of the file, as it is now, that are others than those loaded."""
        matcher = difflib.SequenceMatcher(None, self.content.splitlines(), now.splitlines())
        spans = [
            f"{first + 1}" if last <= first + 1 else f"{first + 1}-{last}"
            for tag, _, _, first, last in matcher.get_opcodes()
            if tag != "equal"
        ]
        if not spans:
            return "line ends differ"
        more = ", …" if len(spans) > 8 else ""
        where = f"{', '.join(spans[:8])}{more}"
        return f"line {where} differs" if where.isdecimal() else f"lines {where} differ"


def _line_starts(text: str) -> list[int]:
    """Where lines begin, as Python's tokenizer counts them: also after a lone carriage return."""
    return [0, *(found.end() for found in re.finditer(r"\r\n|\r|\n", text))]


def _lines(text: str) -> list[str]:
    return io.StringIO(text, newline="\n").readlines()


def _make_newer(path: str, than: os.stat_result) -> None:
    """Gives a file a time of another second: a cached compilation goes by second and size."""
    now = os.stat(path)
    if int(now.st_mtime) <= int(than.st_mtime):
        os.utime(path, (now.st_atime, int(than.st_mtime) + 1))


def _sync_folder(folder: str) -> None:
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
