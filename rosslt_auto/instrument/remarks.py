"""Remarks: what comments in a source file say about its literals.

    SPEED = 0.5                 # rosslt: 0.0 to 2.0 step 0.1
    WHEELS = 4                  # rosslt: frozen
    CALIBRATION = [0.11, 0.97]  # rosslt: off

``off``: nothing there is rewritten. ``on``: in what is off, it is. ``frozen``: tracked and shown,
but nobody changes it. A range: nobody changes it to what is outside.

A remark behind a statement is about the literals in its line, and if there are none (the line has
only the closing bracket), about those of the whole statement. ``off``, ``on`` and ``frozen`` on
the line of a ``def`` or ``class``, in a line of their own before its first statement, or in a line
of their own of its docstring, are about all of it; likewise for a module.
"""

from __future__ import annotations

import ast
import io
import re
import tokenize
from collections.abc import Iterable, Iterator
from importlib.util import decode_source
from typing import Any, NamedTuple

from ..provenance.limits import Limits

MARK = b"rosslt:"
"""A file without this has no remarks, and is not looked at again."""

_COMMENT = re.compile(r"#\s*rosslt:([^#]*)")
_DOCSTRING = re.compile(r"^[ \t]*rosslt:[ \t]*(off|on|frozen)[ \t]*$", re.MULTILINE)
_NUMBER = r"([-+]?(?:\d[\d_]*\.?[\d_]*|\.\d[\d_]*)(?:[eE][-+]?\d+)?)"
_RANGE = re.compile(rf"{_NUMBER}\s+to\s+{_NUMBER}(?:\s+step\s+{_NUMBER})?")
_WORDS = ("off", "on", "frozen")
_SCOPES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
_BLOCKS = ("body", "orelse", "finalbody", "handlers", "cases")
_LAYOUT = (tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT)


class _Bad(ValueError):
    """What is wrong with a remark."""


class _Comment(NamedTuple):
    """alone: in a line of its own; last: the statement, or its header, ends with the line."""

    line: int
    text: str
    alone: bool
    last: bool


class _Range(NamedTuple):
    line: int
    text: str
    ends: tuple[Any, ...]
    lines: frozenset[int]


class Remarks:
    """What all remarks of a file say, by line.

    off       lines in which nothing is rewritten; `everything` if those are all
    frozen    lines whose literals nobody changes
    warnings  ``file:line: what is wrong`` for each remark that is ignored
    """

    def __init__(self, path: str = "") -> None:
        self._path = path
        self.off: set[int] = set()
        self.everything = False
        self.frozen: set[int] = set()
        self._ranges: list[_Range] = []
        self.warnings: list[str] = []

    def is_off(self, node: Any) -> bool:
        """Whether a node of the tree stays as it is."""
        return node.lineno in self.off

    def limits(self, literals: Iterable[Any]) -> dict[Any, tuple[Any, ...]]:
        """Ranges of literals, given as (line, column, node, value, ...), by node."""
        found: dict[Any, tuple[Any, ...]] = {}
        numbers = [
            one for one in literals
            if type(one.value) in (int, float) and one.line not in self.off
        ] if self._ranges else []  # fmt: skip
        for remark in self._ranges:
            meant = [one for one in numbers if one.line in remark.lines]
            try:
                if not meant:
                    raise _Bad("there is no number that it could be for")
                found.update([(one.node, _fitting(remark.ends, one.value)) for one in meant])
            except _Bad as reason:
                self.warn(remark.line, remark.text, reason)
        return found

    def warn(self, line: int, text: str, reason: object) -> None:
        """Notes that a remark is ignored."""
        self.warnings.append(f"{self._path}:{line}: 'rosslt: {text}' is ignored: {reason}")

    def _take(self, scopes: list[tuple[str, frozenset[int]]]) -> None:
        # Inner ones have the last word.
        for word, lines in sorted(scopes, key=lambda one: -len(one[1])):
            if word == "frozen":
                self.frozen |= lines
            elif word == "off":
                self.off |= lines
            else:
                self.off -= lines


def read(source: bytes, tree: ast.Module, path: str) -> Remarks:
    """The remarks of a file; `tree` is its syntax tree, as it is written."""
    remarks = Remarks(path)
    if MARK not in source:
        return remarks
    text = decode_source(source)
    layout = _Layout(tree, text.count("\n") + 1)
    scopes = list(layout.in_docstrings())
    for comment in _comments(text):
        try:
            if comment.text in _WORDS:
                scopes.append((comment.text, layout.meant(comment)))
            else:
                ends = _ends(comment.text)
                remarks._ranges.append(_Range(comment.line, comment.text, ends,
                                              layout.beside(comment)))  # fmt: skip
        except _Bad as reason:
            remarks.warn(comment.line, comment.text, reason)
    remarks._take(scopes)
    remarks.everything = len(remarks.off) >= layout.last
    return remarks


def _comments(text: str) -> Iterator[_Comment]:
    before = 0  # where the last token ends that is more than layout
    tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
    for token, following in zip(tokens, [*tokens[1:], tokens[-1]], strict=True):
        if token.type == tokenize.COMMENT:
            line = token.start[0]
            for found in _COMMENT.finditer(token.string):
                last = following.type == tokenize.NEWLINE
                yield _Comment(line, " ".join(found[1].split()), line != before, last)
        elif token.type not in _LAYOUT:
            before = token.end[0]


# ---------------------------------------------------------------- ranges


def _ends(text: str) -> tuple[Any, ...]:
    """(low, high, step) as written. Raises _Bad."""
    found = _RANGE.fullmatch(text)
    if found is None:
        raise _Bad("known are off, on, frozen, LOW to HIGH, and LOW to HIGH step STEP")
    low, high = _number(found[1]), _number(found[2])
    step = None if found[3] is None else _number(found[3])
    if not low < high:
        raise _Bad(f"{low!r} is not below {high!r}")
    if step is not None and not 0 < step <= high - low:
        raise _Bad(f"{step!r} is no step from {low!r} to {high!r}")
    return low, high, step


def _number(text: str) -> Any:
    try:
        value = ast.literal_eval(text)
    except (SyntaxError, ValueError):
        raise _Bad(f"{text} is no number") from None
    if abs(value) > 1e300:
        raise _Bad(f"{text} is too large")
    return value


def _fitting(ends: tuple[Any, ...], value: Any) -> tuple[Any, ...]:
    """A range as one of numbers of the literal's type, which has to be in it. Raises _Bad."""
    kind = type(value)
    fitting = tuple(None if one is None else kind(one) for one in ends)
    if fitting != ends:
        raise _Bad(f"{value!r} is an int, its range has to be one of ints")
    if not Limits(*fitting).allows(value):
        raise _Bad(f"{value!r} is not in it")
    return fitting


# ---------------------------------------------------------------- where they stand


class _Layout:
    """Which lines the statements, functions and classes of a file have."""

    def __init__(self, tree: ast.Module, last: int) -> None:
        self.tree = tree
        self.last = last
        self.statements = [node for node in ast.walk(tree) if isinstance(node, ast.stmt)]
        self.scopes = [node for node in self.statements if isinstance(node, _SCOPES)]

    def in_docstrings(self) -> Iterator[tuple[str, frozenset[int]]]:
        """What the docstrings say of their modules, classes and functions."""
        for scope in (self.tree, *self.scopes):
            text = ast.get_docstring(scope, clean=False)
            for found in _DOCSTRING.finditer(text or ""):
                yield found[1], self._all(scope)

    def meant(self, comment: _Comment) -> frozenset[int]:
        """The lines that a remark of one word is about. Raises _Bad."""
        line = comment.line
        if comment.alone:
            scope: Any = self._innermost(line)
            body = scope.body[ast.get_docstring(scope, clean=False) is not None :]
            if body and line > _start(body[0]):
                raise _Bad(_ALONE)
            return self._all(scope)
        for scope in self.scopes:
            if _start(scope) <= line <= _header_end(scope) and (
                comment.last or line == scope.lineno
            ):
                return self._all(scope)
        return self.beside(comment)

    def beside(self, comment: _Comment) -> frozenset[int]:
        """The lines of the literals that a remark stands behind. Raises _Bad."""
        if comment.alone:
            raise _Bad(_ALONE)
        line = comment.line
        owners = [one for one in self.statements if _start(one) <= line <= _header_end(one)]
        literals = [
            node
            for owner in owners
            for part in _own_parts(owner)
            for node in ast.walk(part)
            if isinstance(node, ast.Constant) and node.lineno <= line <= (node.end_lineno or 0)
        ]
        if literals or not owners:
            return frozenset({line, *(node.lineno for node in literals)})
        return frozenset().union(*(range(_start(one), _header_end(one) + 1) for one in owners))

    def _innermost(self, line: int) -> ast.AST:
        around = [s for s in self.scopes if s.lineno <= line <= (s.end_lineno or 0)]
        return max(around, key=lambda scope: scope.lineno, default=self.tree)

    def _all(self, scope: Any) -> frozenset[int]:
        if scope is self.tree:
            return frozenset(range(1, self.last + 1))
        return frozenset(range(_start(scope), scope.end_lineno + 1))


_ALONE = "alone in a line it has to be off, on or frozen, and before the first statement"


def _start(statement: Any) -> int:
    return min([statement.lineno, *(d.lineno for d in getattr(statement, "decorator_list", ()))])


def _header_end(statement: Any) -> int:
    """The last line of a statement, or of what stands before its block."""
    body = getattr(statement, "body", None) or getattr(statement, "cases", None)
    if not body:
        return statement.end_lineno
    first = body[0].pattern if isinstance(body[0], ast.match_case) else body[0]
    return max(statement.lineno, _start(first) - 1)


def _own_parts(statement: ast.stmt) -> Iterator[ast.AST]:
    """What a statement is made of, without the statements in it."""
    for name, value in ast.iter_fields(statement):
        if name not in _BLOCKS:
            yield from (one for one in (value if isinstance(value, list) else [value])
                        if isinstance(one, ast.AST))  # fmt: skip
