"""A wanted text taken apart into wanted pieces, where several of them differ at once."""

from __future__ import annotations

import re
from typing import Any

from .expressions import is_leaf, operands
from .extents import check
from .locations import source_of
from .text_operators import NoSuchText, Piece, formatted, parsed, percent_pieces, pieces_of
from .values import is_tracked, untracked

_MANY = 64
_DEEP = 64
"""Texts of more pieces, or with more texts in texts, are not taken apart: that takes too long."""

_NUMBER = r"[ ]*[-+]?[0-9a-fA-FxXob_.,]+(?:[eE][-+]?[0-9]+)?%?[ ]*"


def take_apart(value: Any, target: str) -> list[tuple[Any, Any]] | None:
    """(tracked piece, wanted value) for the pieces of the text `value` that have to change.

    None if `value` is not made of pieces, `target` does not have their form, or nothing is left
    to be changed. Raises TooLarge where the pieces tell of a text beyond all measure.
    """
    if is_tracked(value):
        check(value._op.name, [untracked(operand) for operand in operands(value)])
    pieces = _pieces(value)
    if pieces is None or len(pieces) > _MANY or value._depth > _DEEP:
        return None
    match = re.fullmatch("".join(_pattern(piece) for piece in pieces), target, re.DOTALL)
    if match is None:
        return None
    wanted = []
    for piece, found in zip([p for p in pieces if _is_open(p)], match.groups(), strict=True):
        operand, conversion, spec = piece
        if found == formatted(untracked(operand), conversion, spec):
            continue
        try:
            wanted.append((operand, parsed(found, untracked(operand), conversion, spec)))
        except NoSuchText:
            return None
    return wanted or None


def _pieces(value: Any) -> list[Piece] | None:
    below = operands(value) if is_tracked(value) else ()
    if not below:
        return None
    name = value._op.name
    if name == "pieces":
        return pieces_of(below)
    if name == "percent":
        return percent_pieces(untracked(below[0]), below[1:])
    if name == "concat":
        return [(operand, None, "") for operand in below]
    if name == "join":
        parts: list[Piece] = []
        for operand in below[1:]:
            parts += [(untracked(below[0]), None, ""), (operand, None, "")]
        return parts[1:]
    return None


def _is_open(piece: Piece) -> bool:
    """Whether a piece may differ: tracked, and not the text between the values itself."""
    value = piece[0]
    if not is_tracked(value):
        return False
    return not (type(untracked(value)) is str and is_leaf(value) and not source_of(value).named)


def _pattern(piece: Piece) -> str:
    value, conversion, spec = piece
    if not _is_open(piece):
        return re.escape(formatted(untracked(value), conversion, spec))
    return f"({'.*?' if type(untracked(value)) is str else _NUMBER})"
