"""f-strings: what the rewriter puts around them, so that the text knows its pieces.

``f"{label} {n:d} of 10"`` becomes

    T[0].end(T[0].begin(), f"{T[0].value(label)} {T[0].value(n):d}{T[0].value(' of 10')}")

where ``T`` is the module's list of `strings.Interpolation`. Python itself evaluates and formats
everything, in its order; a piece of text that says something is a literal of its own. Where all
values are names, which can be looked at twice, that is done afterwards:

    T[0].text(f"{label} {n:d}{' of 10'}", label, n, ' of 10')
"""

from __future__ import annotations

import ast
from typing import Any

from .plain import can_be_tracked
from .walk import LOAD, Parts

_UNCHANGING = (ast.Name, ast.Constant)
_SUSPENDING = (ast.Await, ast.Yield, ast.YieldFrom)


def can_be_noted(node: ast.JoinedStr) -> bool:
    """Whether an f-string is one that `interpolated` can do.

    Not where other code may run in between, nor on several lines: what Python says of lines of
    such a one is too intricate.
    """
    return (
        node.lineno == node.end_lineno
        and any(isinstance(part, ast.FormattedValue) for part in node.values)
        and not any(
            isinstance(below, _SUSPENDING) or getattr(below, "is_async", 0)
            for below in ast.walk(node)
        )
    )


def interpolated(node: Any, name: str, index: int) -> tuple[Parts, list[ast.Constant]]:
    """Turns an f-string in place into the call above.

    name, index  of its `Interpolation`
    Returns its parts, and the literals among them.
    """
    parts: list[tuple[str | None, str | None, str | None]] = []
    literals: list[ast.Constant] = []
    values: list[ast.expr] = []
    operands: list[ast.expr] = []
    afterwards = all(
        isinstance(part.value, _UNCHANGING)
        for part in node.values
        if isinstance(part, ast.FormattedValue)
    )

    def noted(value: Any) -> Any:
        operands.append(value)
        return value if afterwards else _call(name, index, "value", value, at=value)

    for at, part in enumerate(node.values):
        if isinstance(part, ast.FormattedValue):
            part.value = noted(part.value)
            conversion = chr(part.conversion) if part.conversion > 0 else None
            parts.append((None, conversion, _specification(part.format_spec)))
        elif _says_something(part, node.values[at + 1 : at + 2]):
            literals.append(part)
            parts.append((None, None, ""))
            part = ast.copy_location(ast.FormattedValue(noted(part), -1, None), part)
        else:
            parts.append((part.value, None, ""))
        values.append(part)
    text = ast.copy_location(ast.JoinedStr(values), node)
    if afterwards:
        call = _call(name, index, "text", text, *operands, at=node)
    else:
        call = _call(name, index, "end", _call(name, index, "begin", at=node), text, at=node)
    del node.values
    node.__class__ = ast.Call
    node.func, node.args, node.keywords = call.func, call.args, call.keywords
    return tuple(parts), literals


def _call(name: str, index: int, method: str, *args: ast.expr, at: ast.expr) -> ast.Call:
    def put(node: Any) -> Any:
        return ast.copy_location(node, at)

    table = put(ast.Subscript(put(ast.Name(name, LOAD)), put(ast.Constant(index)), LOAD))
    return put(ast.Call(put(ast.Attribute(table, method, LOAD)), list(args), []))


def _specification(node: Any) -> str | None:
    """The format specification, None if it is computed itself."""
    if node is None:
        return ""
    if all(isinstance(part, ast.Constant) for part in node.values):
        return "".join(part.value for part in node.values)
    return None


def _says_something(part: Any, following: list[Any]) -> bool:
    if not any(map(str.isalnum, part.value)) or not can_be_tracked(part.value):
        return False
    # The text of ``f"{x=}"`` is no literal but the expression itself.
    shows_itself = following and part.value.rstrip().endswith("=")
    return not (shows_itself and following[0].conversion == ord("r"))
