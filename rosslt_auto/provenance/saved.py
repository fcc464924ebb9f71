"""A source file has been edited to have current values: its literals in this process follow.

Nothing that runs changes. What is known of the literals does - what stands in the file, and where -
so that the next edit finds them, and so that a reload of the edited file meets the same table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from .locations import LiteralInfo, Literals, fingerprint
from .registry import registered, rename
from .source_files import Edit, NotWritten, SourceFile


class LiteralEdit(NamedTuple):
    """A literal's place before the edit (as in Python's ast), its new text, and what that says."""

    line: int
    column: int
    end_line: int
    end_column: int
    text: str
    value: Any


class NotSaved(ValueError):
    """The file is not what it is said to be."""


def adopt(path: str, before: str, after: str, edits: Sequence[LiteralEdit]) -> bool:
    """Takes notice of edits of a file.

    path           as the modules have it that were loaded from the file
    before, after  its fingerprints; modules that have loaded another content are passed over
    Returns whether there was such a module. Raises NotSaved, nothing changed, if the edits do not
    make the one content from the other, or if the file does not have it.
    """
    concerned = [
        literals
        for literals in registered()
        if literals.file == path and literals.content == before and literals.source is not None
    ]
    for literals in concerned:
        _adopt(literals, after, edits)
    return bool(concerned)


def _adopt(literals: Literals, after: str, edits: Sequence[LiteralEdit]) -> None:
    path, content, before = literals.file, literals.source, literals.content
    assert content is not None and before is not None
    try:
        source = SourceFile(path, content)
        changes = [Edit(*source.range(*edit[:4]), edit.text) for edit in edits]
        new = source.edited(changes)
    except (ValueError, NotWritten) as error:
        raise NotSaved(f"{path}: {error}") from None
    if fingerprint(path, new.content) != after:
        raise NotSaved(f"{path}: the edits do not make what is said to be saved")
    try:
        written = source.now()
    except NotWritten as error:
        raise NotSaved(str(error)) from None
    if written != new.content:
        raise NotSaved(f"{path} does not have what is said to be saved")
    edited = {edit[:2]: edit for edit in edits}
    shifted = _shift_by([(one, edit.value) for one, edit in zip(changes, edits, strict=True)])
    infos, values = [], []
    for info, value in zip(literals.infos, literals.values, strict=True):
        edit = edited.get((info.line, info.column))
        infos.append(_moved(info, source, new, shifted))
        values.append(value if edit is None else _of_kind(value, edit.value))
    literals.now_in(new.content, infos, tuple(values))
    rename(literals, literals.name.removesuffix(before) + after)


def _of_kind(value: Any, new: Any) -> Any:
    if type(value) is float and type(new) is int:
        return float(new)
    return new if type(new) is type(value) else value


def _shift_by(
    edits: Sequence[tuple[Edit, Any]],
) -> Callable[[int, int], tuple[int, int]]:
    """What gives the range that a literal has after edits (with their values) for the one before.

    The range of an edited number is that of its new text, without the parentheses or spaces that
    the edit has put around it.
    """
    ordered = sorted(edits, key=lambda one: one[0])

    def shifted(start: int, end: int) -> tuple[int, int]:
        moved = 0
        for edit, value in ordered:
            if (edit.start, edit.end) == (start, end):
                bare = edit.text if type(value) is str else edit.text.strip(" ()")
                lead = edit.text.index(bare)
                return start + moved + lead, start + moved + lead + len(bare)
            longer = len(edit.text) - (edit.end - edit.start)
            if edit.end <= start:
                moved += longer
            elif start <= edit.start and edit.end <= end:  # all of an f-string, for its pieces
                end += longer
        return start + moved, end + moved

    return shifted


def _moved(
    info: LiteralInfo,
    before: SourceFile,
    after: SourceFile,
    shifted: Callable[[int, int], tuple[int, int]],
) -> LiteralInfo:
    try:
        place = before.range(info.line, info.column, info.end_line, info.end_column)
    except ValueError:
        return info  # a place that Python could not tell, in an f-string
    start, end = shifted(*place)
    line, column = after.position(start)
    end_line, end_column = after.position(end)
    return info._replace(line=line, column=column, end_line=end_line, end_column=end_column)
