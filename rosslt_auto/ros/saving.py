"""Writing changed literals back into the source files that they came from.

What nodes say of their literals - where they stood in which content of which file, what they were,
what they are - becomes edits of files (`prepare`), shown as a diff or written. A file is edited
completely or not at all, and only while it is the one that was loaded. Then the nodes are told
(`changes`), so that they and the file agree.
"""

from __future__ import annotations

import ast
import os
import re
import stat
import sys
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from rcl_interfaces.msg import ParameterEvent
from rclpy.qos import qos_profile_parameter_events

from rosslt_auto.provenance.locations import fingerprint
from rosslt_auto.provenance.saved import LiteralEdit
from rosslt_auto.provenance.source_files import Edit, NotWritten, SourceFile
from rosslt_auto.provenance.spelling import CannotSpell, respell, respell_piece, same

from . import changes
from .client import NoAnswer, Place

TELLING = 3.0
"""Seconds within which nodes should have taken notice of what was saved."""

_AGAIN = 0.3


class CannotSave(Exception):
    """Nothing was written; the message says why."""


class Saved(NamedTuple):
    """One literal that has, or would have, a new value in its file."""

    places: Sequence[Place]
    edit: Edit
    known_as: LiteralEdit

    def __str__(self) -> str:
        place = self.places[0]
        where = f"{place.file}:{place.line}:{place.column}"
        return f"{where}: {place.first!r} -> {place.value!r}  {place.parameter}"


@dataclass(frozen=True)
class FileChange:
    """All edits of one file.

    loaded  the fingerprint of its content under each path by which nodes know it
    """

    source: SourceFile
    literals: Sequence[Saved]
    loaded: Mapping[str, str]

    @property
    def edits(self) -> list[Edit]:
        return [one.edit for one in self.literals]

    def diff(self) -> str:
        """What `write` changes, as a unified diff."""
        return self.source.diff(self.edits)

    def write(self) -> None:
        """Writes the file. Raises NotWritten, the file untouched."""
        self.source.write(self.edits)


@dataclass
class Plan:
    """What saving does.

    files    those that can be written
    refused  why others, or literals in them, cannot
    given    literals whose value comes from the start of the node, not from its file
    """

    files: list[FileChange] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    given: list[Place] = field(default_factory=list)

    def diff(self) -> str:
        """What would be written, as a unified diff."""
        return "".join(change.diff() for change in self.files)


@dataclass
class Report:
    """What saving has done; `untold` are nodes that have not taken notice in time."""

    literals: list[Saved] = field(default_factory=list)
    refused: list[str] = field(default_factory=list)
    untold: list[str] = field(default_factory=list)


def differs(place: Place) -> bool:
    """Whether a literal has another value than its file. False for what is no literal."""
    return (
        place.content is not None
        and place.line is not None
        and place.first is not None
        and place.value is not None
        and not same(place.first, place.value)
    )


def given_by(place: Place) -> str | None:
    """What gave a literal its value at start, for people; None if its file did."""
    if place.given is None:
        return None
    where = {"-p": "-p on the command line", "": "-p or a parameter file"}
    return f"given at start by {where.get(place.given, place.given)}"


def where_given(place: Place) -> str:
    """Where a value lives that was given to a literal at start, for people."""
    return (
        f"{place.parameter} of {place.node} is {place.value!r} and not saved: it was"
        f" {given_by(place)}, change it there ({place.file}:{place.line} has {place.first!r})"
    )


# ---------------------------------------------------------------- what to write


def prepare(places: Iterable[Place]) -> Plan:
    """What saving the current values of these places means; reads files, changes nothing."""
    plan = Plan()
    by_file: dict[str, list[Place]] = {}
    for place in places:
        if place.given is not None:
            if differs(place):
                plan.given.append(place)
        elif place.content is not None and place.file is not None:
            by_file.setdefault(os.path.realpath(place.file), []).append(place)
    for found in by_file.values():
        changed = [place for place in found if differs(place)]
        if not changed:
            continue
        try:
            plan.files.append(_file_change(changed, found))
        except (CannotSave, NotWritten) as reason:
            plan.refused.append(str(reason))
    return plan


def _file_change(changed: Sequence[Place], places: Sequence[Place]) -> FileChange:
    """The edits of one file. Raises CannotSave or NotWritten."""
    path = changed[0].file or ""
    content = _read(path)
    loaded = {place.file or "": fingerprint(place.file or "", content) for place in places}
    others = [place for place in changed if place.content != loaded[place.file or ""]]
    source = SourceFile(path, content)
    if others:
        stale = {(place.file, place.content) for place in others}
        lines = [place for place in places if (place.file, place.content) in stale]
        raise CannotSave(f"{path} is not what {others[0].node} has loaded: {_lines(source, lines)}")
    current = [place for place in places if place.content == loaded[place.file or ""]]
    by_position: dict[tuple[int, int], list[Place]] = {}
    for place in current:
        by_position.setdefault((place.line or 0, place.column or 0), []).append(place)
    tree = _Tree(source)
    wanted = sorted({(place.line or 0, place.column or 0) for place in changed})
    literals = [_saved(source, tree, by_position[position]) for position in wanted]
    edits = [one.edit for one in literals]
    nodes = {
        tree.at(line, column): one for (line, column), one in zip(wanted, literals, strict=True)
    }
    if not tree.becomes(
        source.edited(edits), {node: one.known_as.value for node, one in nodes.items()}
    ):
        raise CannotSave(f"{path}: the places of its literals in f-strings cannot be told")
    return FileChange(source, literals, loaded)


def _read(path: str) -> bytes:
    if not os.path.isabs(path):
        raise CannotSave(f"{path}: its node does not say where that is")
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise CannotSave(f"{path} is no regular file")
        with open(path, "rb") as file:
            return file.read()
    except (FileNotFoundError, NotADirectoryError):
        raise CannotSave(f"{path} is not on this machine") from None
    except (OSError, ValueError) as error:
        raise CannotSave(f"{path}: {getattr(error, 'strerror', None) or error}") from None


def _lines(source: SourceFile, places: Sequence[Place]) -> str:
    """Which lines are others than those that were loaded, as far as nodes have told them."""
    last = source.position(len(source.text))[0]
    known = {place.line: place.text for place in places if place.line is not None}
    found = sorted(line for line, text in known.items() if line > last or source.line(line) != text)
    if not found:
        return "other lines differ than those of its literals; start the node again"
    return f"{'lines' if len(found) > 1 else 'line'} {', '.join(map(str, found))} differ" + (
        "" if len(found) > 1 else "s"
    )


def _saved(source: SourceFile, tree: _Tree, places: Sequence[Place]) -> Saved:
    first = places[0]
    where = f"{first.file}:{first.line}:{first.column}"
    node = tree.at(first.line or 0, first.column or 0)
    if node is None or not all(same(tree.value(node), place.first) for place in places):
        raise CannotSave(f"{where}: where in the f-string {first.first!r} is cannot be told")
    for other in places[1:]:
        if not same(first.value, other.value):
            raise CannotSave(
                f"{where} has several values: {first.value!r} in {first.node},"
                f" {other.value!r} in {other.node}; name the node whose value to save"
            )
    end = (node.end_lineno or node.lineno, node.end_col_offset or node.col_offset)
    try:
        start, stop = source.range(node.lineno, node.col_offset, *end)
        text = _spelled(source, tree, node, start, stop, first)
    except (CannotSpell, ValueError) as error:
        raise CannotSave(f"{where}: {error}") from None
    value = first.value
    if type(first.first) is float and type(value) is int:
        value = float(value)
    return Saved(
        places,
        Edit(start, stop, text),
        LiteralEdit(node.lineno, node.col_offset, *end, text, value),
    )


_F_STRING = re.compile(r"""([A-Za-z]*[fF][A-Za-z]*)('''|\"\"\"|'|\")""")


def _spelled(
    source: SourceFile, tree: _Tree, node: ast.expr, start: int, stop: int, place: Place
) -> str:
    text = source.text[start:stop]
    joined = tree.f_string_of(node)
    if joined is None:
        return respell(
            text, place.first, place.value, before=source.text[:start], after=source.text[stop:],
            encoding=source.encoding,
        )  # fmt: skip
    begin = _F_STRING.match(source.text, source.offset(joined.lineno, joined.col_offset))
    if sys.version_info < (3, 12) or begin is None:
        raise CannotSpell("where in the f-string it is cannot be told")
    return respell_piece(
        text, place.first, place.value, prefix=begin[1], quote=begin[2], encoding=source.encoding
    )


# ---------------------------------------------------------------- the file's syntax tree


_NOTHING = object()


class _Tree:
    """The literals of a file by position, signs included. Raises CannotSave."""

    def __init__(self, source: SourceFile) -> None:
        try:
            self.tree = ast.parse(source.content, source.path)
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            raise CannotSave(f"{source.path}: {error}") from None
        self._at: dict[tuple[int, int], list[ast.expr]] = {}
        self._pieces: dict[ast.AST, ast.JoinedStr] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.expr) and self.value(node) is not _NOTHING:
                self._at.setdefault((node.lineno, node.col_offset), []).append(node)
            elif isinstance(node, ast.JoinedStr):
                self._pieces.update((part, node) for part in node.values)

    def at(self, line: int, column: int) -> ast.expr | None:
        """The literal that begins there, None if there is none, or several: not a true place."""
        found = self._at.get((line, column), [])
        return found[0] if len(found) == 1 else None

    def f_string_of(self, node: ast.AST) -> ast.JoinedStr | None:
        """The f-string whose text a literal is a piece of."""
        return self._pieces.get(node)

    @staticmethod
    def value(node: ast.AST) -> Any:
        """The value of a literal, sign included."""
        if isinstance(node, ast.Constant):
            return node.value
        if isinstance(node, ast.UnaryOp) and isinstance(node.operand, ast.Constant):
            value = node.operand.value
            if type(value) in (int, float):
                if isinstance(node.op, ast.USub):
                    return -value  # type: ignore[operator]
                if isinstance(node.op, ast.UAdd):
                    return value
        return _NOTHING

    def becomes(self, edited: SourceFile, values: Mapping[ast.expr | None, Any]) -> bool:
        """Whether the edited file is the same program but for these values of these literals."""
        try:
            stack: list[tuple[Any, Any]] = [(self.tree, ast.parse(edited.content, edited.path))]
        except (SyntaxError, ValueError, RecursionError, MemoryError):
            return False
        while stack:
            old, new = stack.pop()
            if isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
                stack += zip(old, new, strict=True)
            elif isinstance(old, ast.AST) and isinstance(new, ast.AST):
                value = values.get(old, self.value(old)) if isinstance(old, ast.expr) else _NOTHING
                if value is not _NOTHING:
                    found = self.value(new)
                    if type(found) is not type(value) or repr(found) != repr(value):
                        return False
                elif type(old) is not type(new):
                    return False
                else:
                    stack += ((getattr(old, f, None), getattr(new, f, None)) for f in old._fields)
            elif type(old) is not type(new) or old != new:
                return False
        return True


# ---------------------------------------------------------------- writing, and telling the nodes


class Saver:
    """Saves what nodes have now. Used by the command line and by views.

    observer  has been entered
    """

    def __init__(self, observer: Any) -> None:
        self._observer = observer
        self._publisher: Any = None

    def places(self, timeout: float, say: Callable[[str], None] = lambda _: None) -> list[Place]:
        """The locations of all nodes; `say` is told of those that do not answer."""
        found: list[Place] = []
        for node in sorted(self._observer.nodes_with_locations()):
            try:
                found += self._observer.parameters.places(node, timeout)
            except NoAnswer as error:
                say(str(error))
        return found

    def write(self, plan: Plan, places: Sequence[Place]) -> Report:
        """Writes the files and tells the nodes, of which `places` are the locations."""
        report = Report(refused=list(plan.refused))
        written = []
        for change in plan.files:
            try:
                change.write()
            except NotWritten as reason:
                report.refused.append(str(reason))
            else:
                written.append(change)
                report.literals += change.literals
        news = _news(written, places)
        report.untold = self._tell(news) if news else []
        return report

    def _tell(self, news: Mapping[str, Sequence[Any]]) -> list[str]:
        """Tells nodes until they know; returns those that do not in time."""
        node = self._observer.node
        if self._publisher is None:
            self._publisher = node.create_publisher(
                ParameterEvent, changes.TOPIC, qos_profile_parameter_events
            )
        deadline = time.monotonic() + TELLING
        left = set(news)
        while left:
            for name in left:
                event = ParameterEvent(node=name, new_parameters=[one for one, _ in news[name]])
                event.stamp = node.get_clock().now().to_msg()
                self._publisher.publish(event)
            again = min(time.monotonic() + _AGAIN, deadline)
            while left and time.monotonic() < again:
                left = {name for name in left if not self._knows(name, news[name], deadline)}
                time.sleep(0.01)
            if time.monotonic() >= deadline:
                break
        return sorted(left)

    def _knows(self, name: str, news: Sequence[Any], deadline: float) -> bool:
        """Whether no location of the node is one of the content before."""
        before = {key for _, key in news}
        try:
            places = self._observer.parameters.places(name, max(0.1, deadline - time.monotonic()))
        except NoAnswer:
            return False
        return not any((place.file, place.content) in before for place in places)


def _news(
    written: Iterable[FileChange], places: Sequence[Place]
) -> dict[str, list[tuple[Any, tuple[str, str]]]]:
    """By node: what to tell it, with the (path, fingerprint) that it is about."""
    news: dict[str, list[tuple[Any, tuple[str, str]]]] = {}
    for change in written:
        content = change.source.edited(change.edits).content
        edits = [one.known_as for one in change.literals]
        real = os.path.realpath(change.source.path)
        concerned = {
            (place.node, place.file, place.content)
            for place in places
            if place.file and place.content and os.path.realpath(place.file) == real
        }
        for node, path, before in sorted(concerned):
            if before == fingerprint(path, change.source.content):
                message = changes.saved_parameter(path, before, fingerprint(path, content), edits)
                news.setdefault(node, []).append((message, (path, before)))
    return news


class ViewSaver:
    """The `Saver` of `views.session`."""

    TIMEOUT = 2.0

    def __init__(self, observer: Any) -> None:
        self._saver = Saver(observer)

    def _prepare(self, literals: Sequence[Any]) -> tuple[Plan, list[Place]]:
        places = self._saver.places(self.TIMEOUT)
        wanted = {(one.node, one.parameter) for one in literals}
        return prepare(selected(places, {node for node, _ in wanted})), places

    def diff(self, literals: Sequence[Any]) -> str:
        """What `save` would write, with what it would not, if there is anything to write.

        Raises CannotSave.
        """
        plan, _ = self._prepare(literals)
        reasons = [*plan.refused, *map(where_given, plan.given)]
        if not plan.files:
            raise CannotSave("; ".join(reasons) or "nothing to save")
        return "".join(f"not saved: {reason}\n" for reason in reasons) + plan.diff()

    def save(self, literals: Sequence[Any]) -> str:
        """Writes; returns what was done. Raises CannotSave if nothing was."""
        plan, places = self._prepare(literals)
        report = self._saver.write(plan, places)
        reasons = [*report.refused, *map(where_given, plan.given)]
        if not report.literals:
            raise CannotSave("; ".join(reasons) or "nothing to save")
        files = sorted({os.path.basename(one.places[0].file or "") for one in report.literals})
        count = len(report.literals)
        parts = [f"saved {count} {'value' if count == 1 else 'values'} in {', '.join(files)}"]
        parts += [f"not saved: {reason}" for reason in reasons]
        parts += [f"{node} has not taken notice" for node in report.untold]
        return "; ".join(parts)


def selected(places: Iterable[Place], nodes: Collection[str]) -> list[Place]:
    """The places of these nodes."""
    return [place for place in places if place.node in nodes]


__all__ = [
    "CannotSave",
    "Plan",
    "Report",
    "Saver",
    "ViewSaver",
    "given_by",
    "prepare",
    "selected",
    "where_given",
]
