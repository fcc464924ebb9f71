"""The literals behind what is shown: where they stand, and the values that they have now."""

from __future__ import annotations

import ast
import os
import re
import threading
import tokenize
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from rosslt_auto.provenance.sources import Source

_READABLE = (".py", ".yaml", ".yml", ".json")
_MAX_BYTES = 1 << 20

Name = tuple[str, str]
"""A node, and a parameter of it."""


@dataclass(frozen=True)
class Literal:
    """A place that can be changed.

    first  the value in the source file, None if nobody said so
    line, column   from 1 and from 0 (in UTF-8, as in Python's ast); None where there is no file
    frozen  the node lets nobody change it
    given   where the value lives if it was given to the literal at start, else None
    in_data whether it stands in a data file, which follows every change, and not in a program
    """

    node: str
    parameter: str
    file: str | None
    line: int | None
    column: int | None
    text: str
    first: Any
    value: Any
    frozen: bool = False
    given: str | None = None
    in_data: bool = False

    @property
    def differs(self) -> bool:
        """Whether the value is not the one in the file."""
        return not self.in_data and self.first is not None and self.first != self.value

    @property
    def changed(self) -> bool:
        """Whether somebody has changed it, and it could be saved."""
        return self.differs and self.given is None


@dataclass(frozen=True)
class Marked:
    """A literal in a line of text: characters from start to end."""

    start: int
    end: int
    literal: Literal


@dataclass(frozen=True)
class SourceFile:
    """A file with the literals in it.

    lines    its text, None if it cannot be read here
    marked   literals by line, from left to right
    errors   by line: what a node has complained about
    """

    path: str
    lines: tuple[str, ...] | None
    marked: Mapping[int, list[Marked]]
    errors: Mapping[int, str] = field(default_factory=dict)


class Listing:
    """All known literals, fed by whoever hears of one. `revision` rises with every news."""

    def __init__(self) -> None:
        self._known: dict[Name, Literal] = {}
        self._lock = threading.Lock()
        self._files: dict[str, tuple[Any, _Text | None]] = {}
        self._errors: dict[str, tuple[Any, dict[int, str]]] = {}
        self._weights: dict[Name, int] = {}
        self._ended: frozenset[str] = frozenset()
        self.revision = 0

    def place(self, literal: Literal) -> None:
        """A node has told all about a literal."""
        self._put((literal.node, literal.parameter), literal)

    def source(self, source: Source, value: Any, weight: int = 1) -> None:
        """What can be dragged was computed from a source, which therefore matters.

        weight  how much; 2 if it is what a drag changes
        """
        if source.node is None:
            return
        name = (source.node, source.parameter)
        if self._weights.get(name, 0) < weight:
            self._weights[name] = weight
            self.revision += 1
        known = self._known.get(name)
        if known is None or (known.line is None and source.line is not None):
            self._put(
                name,
                Literal(source.node, source.parameter, source.file, source.line, source.column,
                        source.text or "", None, value),
            )  # fmt: skip

    def value(self, node: str, parameter: str, value: Any) -> None:
        """A literal has a new value."""
        known = self._known.get((node, parameter))
        if known is not None:
            self._put((node, parameter), replace(known, value=value))

    def _put(self, name: Name, literal: Literal) -> None:
        with self._lock:
            if self._known.get(name) != literal:
                self._known[name] = literal
                self.revision += 1

    def forget(self, node: str, but: Iterable[str] = ()) -> None:
        """Forgets the literals of a node, except these parameters."""
        kept = set(but)
        with self._lock:
            for name in [n for n in self._known if n[0] == node and n[1] not in kept]:
                del self._known[name]
                self.revision += 1

    def get(self, source: Source) -> Literal | None:
        """What is known of a source."""
        return self._known.get((source.node or "", source.parameter))

    def frozen(self, source: Source) -> bool:
        """Whether the node is known to let nobody change it, or to be no more."""
        found = self.get(source)
        return source.node in self._ended or (found is not None and found.frozen)

    @property
    def ended(self) -> frozenset[str]:
        """The nodes that are no more: nobody can change anything of them."""
        return self._ended

    @ended.setter
    def ended(self, nodes: Iterable[str]) -> None:
        self._ended = frozenset(nodes)

    def literals(self) -> list[Literal]:
        """All of them."""
        with self._lock:
            return list(self._known.values())

    def changed(self) -> list[Literal]:
        """Those that somebody has changed and that could be saved."""
        return [one for one in self.literals() if one.changed]

    # Files

    def complaint(self, text: str) -> bool:
        """Marks the line of a known file that an error message with a traceback ends in.

        Returns whether there was one.
        """
        known = {one.file for one in self.literals() if one.file}
        folders = {os.path.dirname(path) for path in known}
        found = [
            match
            for match in re.finditer(r'File "(.+?)", line (\d+)', text)
            if match[1] in known or os.path.dirname(match[1]) in folders
        ]
        if not found:
            return False
        path, line = found[-1][1], int(found[-1][2])
        reason = text.strip().splitlines()[-1]
        with self._lock:
            stamp = _stamp(path)
            entry = self._errors.get(path)
            errors = dict(entry[1]) if entry is not None and entry[0] == stamp else {}
            if errors.get(line) != reason:
                self._errors[path] = (stamp, errors | {line: reason})
                self.revision += 1
        return True

    def errors(self) -> list[str]:
        """What nodes complain about, with the place."""
        return [
            f"{os.path.basename(path)}:{line}: {reason}"
            for path, (_, errors) in list(self._errors.items())
            for line, reason in errors.items()
        ]

    def files(self) -> list[SourceFile]:
        """The files with literals that matter: those with changed ones, those that drags change."""
        by_file: dict[str, list[Literal]] = {}
        weights: dict[str, int] = {}
        for literal in self.literals():
            weight = self._weights.get((literal.node, literal.parameter), 0)
            if literal.line is None or not (weight or literal.differs):
                continue
            assert literal.file is not None
            by_file.setdefault(literal.file, []).append(literal)
            weights[literal.file] = weights.get(literal.file, 0) + (weight > 1)
        for path in self._errors:
            by_file.setdefault(path, [])
        found = [self._file(path, literals) for path, literals in by_file.items()]
        changed = {path for path, ones in by_file.items() if any(one.differs for one in ones)}
        return sorted(
            found,
            key=lambda one: (
                not one.errors,
                one.path not in changed,
                -weights.get(one.path, 0),
                one.path,
            ),
        )

    def look(self) -> None:
        """Notices files that have been changed on the disk."""
        for path, (stamp, _) in list(self._files.items()):
            if _stamp(path) != stamp:
                self._files.pop(path, None)
                self.revision += 1
        for path, (stamp, _) in list(self._errors.items()):
            if _stamp(path) != stamp:
                with self._lock:
                    self._errors.pop(path, None)
                    self.revision += 1

    def _file(self, path: str, literals: list[Literal]) -> SourceFile:
        stamp = _stamp(path)
        entry = self._files.get(path)
        if entry is None or entry[0] != stamp:
            entry = (stamp, _Text.read(path))
            self._files[path] = entry
        text = entry[1]
        marked: dict[int, list[Marked]] = {}
        for one in literals:
            assert one.line is not None and one.column is not None
            line = text.line(one.line) if text is not None else one.text
            start, end = text.span(one.line, one.column) if text is not None else (0, 0)
            if start <= len(line):
                marked.setdefault(one.line, []).append(Marked(start, end, one))
        for found in marked.values():
            found.sort(key=lambda one: one.start)
        errors = self._errors.get(path, (None, {}))[1]
        return SourceFile(path, text.lines if text is not None else None, marked, errors)


def _stamp(path: str) -> Any:
    try:
        status = os.stat(path)
    except OSError:
        return None
    return (status.st_mtime_ns, status.st_size, status.st_ino)


class _Text:
    """The text of a file, and where its literals end."""

    def __init__(self, lines: tuple[str, ...], ends: Mapping[tuple[int, int], int]) -> None:
        self.lines = lines
        self._ends = ends

    @classmethod
    def read(cls, path: str) -> _Text | None:
        """The text; None if it cannot be read. Paths come from the network: only source files."""
        if not path.endswith(_READABLE):
            return None
        try:
            if os.path.getsize(path) > _MAX_BYTES:
                return None
            with tokenize.open(path) if path.endswith(".py") else open(path) as file:
                text = file.read()
        except (OSError, SyntaxError, ValueError):
            return None
        return cls(tuple(text.splitlines()), _ends(text) if path.endswith(".py") else {})

    def line(self, number: int) -> str:
        return self.lines[number - 1] if 0 < number <= len(self.lines) else ""

    def span(self, line: int, column: int) -> tuple[int, int]:
        """Start and end of the literal there, in characters."""
        text = self.line(line)
        start = _characters(text, column)
        end = self._ends.get((line, column))
        if end is not None:
            return start, _characters(text, end)
        found = re.compile(r"[-+]?[\w.]+").match(text, start)
        return start, found.end() if found else start


def _characters(line: str, column: int) -> int:
    """A column in UTF-8 as one in characters."""
    return len(line.encode()[:column].decode(errors="ignore"))


def _ends(text: str) -> dict[tuple[int, int], int]:
    """End columns of the literals of one line by their place, signs included."""
    try:
        tree = ast.parse(text)
    except (SyntaxError, ValueError, RecursionError):
        return {}
    found: dict[tuple[int, int], int] = {}
    for node in ast.walk(tree):
        signed = isinstance(node, ast.UnaryOp) and isinstance(node.operand, ast.Constant)
        if not isinstance(node, ast.expr) or not (signed or isinstance(node, ast.Constant)):
            continue
        if node.end_lineno == node.lineno and node.end_col_offset is not None:
            found[node.lineno, node.col_offset] = node.end_col_offset
    return found
