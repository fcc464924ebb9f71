"""Expressions as people write them: named sources by name, coefficients by value."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from .expressions import is_leaf, operands, topological
from .locations import source_of
from .text_operators import pieces_of
from .values import is_tracked

TEXT_LIMIT = 200

_ATOM = 99
_MINUS = 14
_Part = tuple[str, int]
"""A text, and how strongly it holds together."""


def text(value: Any) -> str:
    """The expression of a value, ``2 * count``; shortened in the middle where it is long."""
    if not is_tracked(value):
        return repr(value)
    texts: dict[int, _Part] = {}
    for node in topological([value]):
        texts[id(node)] = _node_text(node, texts)
    return texts[id(value)][0]


def _node_text(node: Any, texts: Mapping[int, _Part]) -> _Part:
    if is_leaf(node):
        source = source_of(node)
        return (source.hint if source.named else repr(node._v), _ATOM)
    below = operands(node)
    parts = [_operand_text(operand, texts) for operand in below]
    special = _SPECIAL.get(node._op.name)
    if special is not None:
        return (_shortened(special(parts, below)), 12)
    precedence = node._op.precedence
    if precedence is None:
        return (_shortened(f"{node._op.symbol}({_list(parts)})"), _ATOM)
    bound = [
        part if strength > precedence or (strength == precedence and not i) else f"({part})"
        for i, (part, strength) in enumerate(parts)
    ]
    if len(bound) == 1:
        return (_shortened(node._op.symbol + bound[0]), precedence)
    return (_shortened(f" {node._op.symbol} ".join(bound)), precedence)


def _operand_text(operand: Any, texts: Mapping[int, _Part]) -> _Part:
    if is_tracked(operand):
        return texts[id(operand)]
    negative = isinstance(operand, (int, float)) and operand < 0
    return (repr(operand), _MINUS if negative else _ATOM)


def _list(parts: list[_Part]) -> str:
    return ", ".join(part for part, _ in parts)


def _affine(parts: list[_Part], below: tuple[Any, ...]) -> str:
    """``5.2 + (init - 10.0) + 2044 * (step - 0.1)``"""
    found = parts[0][0]
    for i in range(1, len(below), 4):
        slope = below[i + 2]
        sign, size = ("-", -slope) if slope < 0 else ("+", slope)
        factor = "" if size == 1 else f"{size:.6g} * "
        found += f" {sign} {factor}({parts[i][0]} - {parts[i + 1][0]})"
    return found


def _linear(parts: list[_Part], below: tuple[Any, ...]) -> str:
    return f"≈ {_affine(parts, below)}"


def _pieces(parts: list[_Part], below: tuple[Any, ...]) -> str:
    """An f-string again."""
    found = ""
    for i, (value, conversion, spec) in enumerate(pieces_of(below)):
        if not is_tracked(value) and isinstance(value, str) and not conversion and not spec:
            found += value.replace("{", "{{").replace("}", "}}")
            continue
        how = f"!{conversion}" if conversion and conversion != "%" else ""
        found += "{" + parts[3 * i][0] + how + (f":{spec.lstrip('%')}" if spec else "") + "}"
    return f"f{found!r}"


def _slice(parts: list[_Part], below: tuple[Any, ...]) -> str:
    bounds = ["" if bound is None else str(bound) for bound in below[1:]]
    return f"{parts[0][0]}[{':'.join(bounds).removesuffix(':')}]"


_SPECIAL: dict[str, Callable[[list[_Part], tuple[Any, ...]], str]] = {
    "affine": _affine,
    "linear": _linear,
    "excerpts": lambda parts, below: f"≈ {' + '.join(part for part, _ in parts)}",
    "pieces": _pieces,
    "slice": _slice,
    "join": lambda parts, below: f"{parts[0][0]}.join({_list(parts[1:])})",
    "format": lambda parts, below: f"{parts[0][0]}.format({_list(parts[1:])})",
    "percent": lambda parts, below: f"{parts[0][0]} % ({_list(parts[1:])})",
    "remembered": lambda parts, below: f"{parts[0][0]} from ({_list(parts[1:])})",
}


def _shortened(found: str) -> str:
    if len(found) <= TEXT_LIMIT:
        return found
    half = TEXT_LIMIT // 2
    return f"{found[:half]} … {found[-half:]}"
