"""Sources of this process that are no literals: ``create_location`` (Section IV-A of the paper).

What may be behind one - a device, a database, a file - can refuse a value, so changes of several
sources are made here together: all of them, or none.
"""

from __future__ import annotations

import ast
import linecache
import logging
import math
import threading
from collections.abc import Callable, Mapping
from types import FrameType
from typing import Any

from .registry import free_name, register_source
from .sources import INT64, Source, SourceChangeRefused
from .tokens import calling_frame, module_prefix, token
from .values import leaf, untracked

_log = logging.getLogger(__name__)
_lock = threading.RLock()


class LocalSource(Source):
    """A source of this process that is no literal.

    first  the value that it had in the beginning
    leaf   the current leaf, which is what the program gets from now on
    reads  how often the program has asked for the value
    """

    def __init__(
        self,
        parameter: str,
        value: Any,
        hint: str | None = None,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        text: str | None = None,
    ) -> None:
        super().__init__(
            None, parameter, type(value).__name__, hint, True, file, line, column, text
        )
        self.first = value
        self.leaf = leaf(self, value)
        self.reads = 0

    # One place, one object; `node` is filled in later.
    __eq__ = object.__eq__
    __hash__ = object.__hash__

    @property
    def value(self) -> Any:
        return self.leaf._v

    @property
    def repeated(self) -> bool:  # type: ignore[override]
        """Whether the program asks for it again and again (design 3.2)."""
        return self.reads > 1

    def set(self, value: Any) -> None:
        """Notes the value that there is now; the leaf stays if it is the same."""
        if value != self.value:
            self.leaf = leaf(self, value)

    def change(self, value: Any) -> None:
        """Changes what is behind it to a value that `check` has passed.

        Raises SourceChangeRefused, nothing changed.
        """
        self.leaf = leaf(self, value)

    def start_with(self, value: Any) -> None:
        """Takes the value that was given for it at start."""
        self.change(value)

    def change_together(self, changes: Mapping[Any, Any]) -> None:
        """`change` for those of several sources that are changed in one step with this one."""
        for source, value in changes.items():
            source.change(value)

    @staticmethod
    def can_be(value: Any) -> bool:
        """Whether a source can have this value in the beginning: one that a parameter can hold."""
        kind = type(value)
        if kind is float:
            return math.isfinite(value)
        return kind is str or (kind is int and value in INT64)

    @property
    def group(self) -> Any:
        """What sources that are changed in one step have in common."""
        return self


def change_all(changes: Mapping[Any, Any]) -> None:
    """Changes sources of this process to values that their `check` has passed; all or none.

    Raises SourceChangeRefused; what had been changed before the refusal is set back.
    """
    groups: dict[Any, dict[Any, Any]] = {}
    for source, value in changes.items():
        if isinstance(source, LocalSource):
            groups.setdefault(source.group, {})[source] = value
    done: list[tuple[dict[Any, Any], list[Any]]] = []
    # What the program's own functions may refuse first: files can tell beforehand.
    for group in sorted(groups.values(), key=lambda group: next(iter(group)).group not in group):
        before = [source.leaf for source in group]
        try:
            next(iter(group)).change_together(group)
        except SourceChangeRefused:
            for changed, leaves in reversed(done):
                _set_back(changed, leaves)
            raise
        done.append((group, before))
    for source, value in changes.items():  # literals last: they refuse nothing
        if not isinstance(source, LocalSource):
            source.change(value)


def _set_back(changed: dict[Any, Any], leaves: list[Any]) -> None:
    before = dict(zip(changed, leaves, strict=True))
    try:
        next(iter(changed)).change_together({s: old._v for s, old in before.items()})
    except SourceChangeRefused as refusal:
        _log.error("a change could not be taken back: %s", refusal)
        return
    for source, old in before.items():
        if source.value == old._v:
            source.leaf = old  # what was computed from it is not out of date


# ---------------------------------------------------------------- create_location


class ExternalSource(LocalSource):
    """A value from `create_location`, with the functions that read and write it."""

    getter: Callable[[], Any] | None = None
    setter: Callable[[Any], Any] | None = None

    def read(self) -> Any:
        """The current leaf, after a look at what is behind it.

        Raises what the getter raises, TypeError if it gives another kind of value.
        """
        self.reads += 1
        if self.getter is not None:
            self.set(self._got())
        return self.leaf

    def _got(self) -> Any:
        assert self.getter
        return self.accepted(untracked(self.getter()))

    def accepted(self, value: Any) -> Any:
        """`value`, which the program itself gives, as a value of this source's kind.

        What a device says may be no finite number. Raises TypeError for another kind.
        """
        if self.kind == "float" and type(value) in (float, int):
            return float(value)
        if type(value).__name__ != self.kind:
            raise TypeError(f"{self.parameter}: {value!r} is not of type {self.kind}")
        return value

    def change(self, value: Any) -> None:
        if self.setter is not None:
            try:
                self.setter(value)
            except Exception as error:
                raise SourceChangeRefused(f"{self.parameter}: {error or repr(error)}") from error
        self.leaf = leaf(self, value)
        if self.getter is None:
            return
        try:
            self.set(self._got())  # a device may have set itself to something near
        except Exception:
            _log.debug("%s cannot be read back", self.parameter, exc_info=True)


_made: dict[Any, ExternalSource] = {}


def create_location(
    value: Any,
    name: str | None = None,
    getter: Callable[[], Any] | None = None,
    setter: Callable[[Any], Any] | None = None,
) -> Any:
    """`value` as a tracked value whose source is the place of this call.

    value   a float, int or str; None if there is a getter
    name    by which it is found and shown, below the calling module's; by default the function's
            and the variable's that it is assigned to
    getter  gives the value that there is now; asked at every call
    setter  is given a new value when the source is changed; an exception refuses it

    Later calls from the same place (with the same name) give the current value of the same
    location, with the getter and setter that they pass. Raises TypeError for another type of value.
    """
    frame = calling_frame()
    assert frame is not None
    value, name = untracked(value), untracked(name)
    with _lock:
        key = (frame.f_code.co_filename, frame.f_code.co_qualname, _position(frame), name)
        source = _made.get(key)
        if source is None:
            if value is None and getter is not None:
                value = untracked(getter())
            source = _made[key] = _make(frame, value, name, setter)
            source.getter, source.setter = getter, setter
            register_source(source)
        else:
            source.getter, source.setter = getter, setter
    return source.read()


def _make(frame: FrameType, value: Any, name: str | None, setter: Any) -> ExternalSource:
    if type(value) not in (float, int, str):
        raise TypeError(f"a location is a float, an int or a str, not {type(value).__name__}")
    file = frame.f_code.co_filename
    line, column, end_line, end_column = _position(frame)[:4]
    if name is None:
        hint = _bound_name(frame, line, column, end_line, end_column) or "value"
        parts = [part for part in frame.f_code.co_qualname.split(".") if part != "<locals>"]
        tokens = [token(part.strip("<>")) for part in parts if part != "<module>"] + [token(hint)]
    else:
        tokens = [token(part) for part in name.split(".")]
        hint = tokens[-1]
    parameter = free_name(".".join((module_prefix(frame), *tokens)))
    text = linecache.getline(file, line, frame.f_globals).strip() if line else None
    return ExternalSource(parameter, value, hint, file, line, column, text)


def _position(frame: FrameType) -> tuple[Any, ...]:
    """Line, column, last line, last column in Python's ast; the instruction where these lack."""
    positions = list(frame.f_code.co_positions())
    line, end_line, column, end_column = positions[frame.f_lasti // 2]
    return (line or frame.f_lineno, column, end_line, end_column,
            frame.f_lasti if column is None else None)  # fmt: skip


def _bound_name(frame: FrameType, *position: Any) -> str | None:
    """The variable or attribute that a call's value is assigned to, if its source shows it."""
    source = "".join(linecache.getlines(frame.f_code.co_filename, frame.f_globals))
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError, RecursionError):
        return None
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            target, value = node.targets[0], node.value
        elif isinstance(node, (ast.AnnAssign, ast.NamedExpr)) and node.value is not None:
            target, value = node.target, node.value
        else:
            continue
        where = (value.lineno, value.col_offset, value.end_lineno, value.end_col_offset)
        if where == position:
            return getattr(target, "id", None) or getattr(target, "attr", None)
    return None
