"""What stays as it is written: where tracking a literal would be wrong or pointless.

The rule is that nothing may behave differently (design 3.6 and 5). The rewriter asks here about
single nodes and names; contexts (comparisons, indices, annotations, ...) are its own business.
"""

from __future__ import annotations

import ast
import math
from typing import Any

INT64_MAX = 2**63 - 1


def _fits(value: int) -> bool:
    return -INT64_MAX - 1 <= value <= INT64_MAX


KINDS: dict[type, Any] = {int: _fits, float: math.isfinite}
"""Kinds of literals that are tracked, and which values of them: those a ROS parameter can hold."""

LARGE = 256
"""A display (list, tuple, dict) with more literals than this is data, and left alone."""

PLAIN_FROM: dict[str, int] = {
    "range": 0, "exit": 0, "_exit": 0, "quit": 0, "chr": 0, "bytes": 0, "bytearray": 0,
    "isinstance": 0, "islice": 1, "round": 1, "int": 1, "enumerate": 1, "to_bytes": 0,
}  # fmt: skip
"""Functions for which positional literals from an index on are plumbing: counts, digits, bases."""

RUN_ONCE = frozenset({"__init__", "__post_init__", "__new__"})
"""Methods that run once for each object (`LiteralInfo.repeated`)."""

RETURNS_PLAIN = frozenset(
    {"__int__", "__index__", "__float__", "__complex__", "__trunc__", "__len__", "__length_hint__",
     "__hash__", "__sizeof__"}
)  # fmt: skip
"""Methods from which Python wants an exact number (a subclass is deprecated or pointless)."""

_ENUMS = ("Enum", "Flag")

_NEVER_TRACKED = (
    ast.Compare, ast.JoinedStr, ast.List, ast.Dict, ast.Set, ast.Tuple, ast.Lambda,
    ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp,
)  # fmt: skip
_SEQUENCES = (ast.List, ast.Tuple, ast.ListComp, ast.JoinedStr)


def can_be_tracked(value: Any) -> bool:
    """Whether a literal of this value becomes a location."""
    fits = KINDS.get(type(value))
    return fits is not None and fits(value)


def can_evaluate_to_tracked(node: ast.expr) -> bool:
    """Whether an expression could give a tracked value at run time."""
    return not isinstance(node, (ast.Constant, *_NEVER_TRACKED))


def is_sequence(node: ast.expr) -> bool:
    """Whether this is seen to be a sequence, so that ``*`` repeats it."""
    if isinstance(node, ast.Constant):
        return isinstance(node.value, (str, bytes))
    return isinstance(node, _SEQUENCES)


def is_special(name: str | None) -> bool:
    """Whether Python or a library gives the name a meaning: ``__slots__``, ``_fields_``."""
    return name is not None and len(name) > 2 and name[0] == "_" and name[-1] == "_"


def is_enum(class_definition: ast.ClassDef, known: set[str]) -> bool:
    """Whether the class is an enumeration, by the names of its bases (or `known` ones)."""
    for base in class_definition.bases:
        name = last_name(base)
        if name is not None and (name.endswith(_ENUMS) or name in known):
            return True
    return False


def plain_from(callee: str | None) -> int:
    """The index of the first positional argument whose literals stay plain; large if none."""
    if callee is None:
        return LARGE
    if callee.endswith(_ENUMS):  # the functional way to make an enumeration
        return 0
    return PLAIN_FROM.get(callee, LARGE)


def last_name(node: ast.expr | None) -> str | None:
    """The last name in an expression like ``self.create_timer``, ``f()``, ``a.b[0]``."""
    while node is not None:
        if isinstance(node, ast.Name):
            return node.id
        if isinstance(node, ast.Attribute):
            return node.attr
        if isinstance(node, ast.Call):
            node = node.func
        elif isinstance(node, (ast.Subscript, ast.Starred, ast.Await)):
            node = node.value
        elif isinstance(node, ast.Lambda):
            return "lambda"
        else:
            return None
    return None


def target_name(node: ast.expr | None) -> str | None:
    """The name that an assignment to `node` binds its value to."""
    if isinstance(node, ast.Subscript):
        key = node.slice
        if isinstance(key, ast.Constant) and isinstance(key.value, str) and key.value:
            return key.value
    elif isinstance(node, (ast.Tuple, ast.List)):
        return target_name(node.elts[0]) if node.elts else None
    return last_name(node)
