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


def _can_be_sent(text: str) -> bool:
    if not 0 < len(text) <= LONG or "\0" in text:
        return False
    try:
        text.encode()
    except UnicodeEncodeError:  # half of a surrogate pair
        return False
    return True


KINDS: dict[type, Any] = {int: _fits, float: math.isfinite, str: _can_be_sent}
"""Kinds of literals that are tracked, and which values of them: those a ROS parameter can hold."""

LONG = 1024
"""A longer text is a document, and left alone."""

LARGE = 256
"""A display (list, tuple, dict) with more literals than this is data, and left alone."""

PLAIN_FROM: dict[str, int] = {
    "range": 0, "exit": 0, "_exit": 0, "quit": 0, "chr": 0, "bytes": 0, "bytearray": 0,
    "isinstance": 0, "islice": 1, "round": 1, "int": 1, "enumerate": 1, "to_bytes": 0,
}  # fmt: skip
"""Functions for which positional literals from an index on are plumbing: counts, digits, bases."""

ALL = LARGE

_NAMES_THINGS = (
    "Enum", "Flag", "NamedTuple", "NewType", "Parameter", "Node", "LifecycleNode", "ParamSpec",
    "TypeVar", "TypedDict", "create_node", "__init__", "declare_parameter", "get", "get_parameter",
    "get_parameter_or", "has_parameter", "pop", "setdefault", "undeclare_parameter",
)  # fmt: skip
_WITH_TEXTS_OF_ITS_OWN = (
    "Decimal", "Fraction", "Path", "PurePath", "TypeVar", "NamedTuple", "NewType", "TypedDict",
    "ParamSpec", "__import__", "add_argument", "add_parser", "attrgetter", "bytearray", "bytes",
    "cast", "compile", "complex", "count", "critical", "debug", "decode", "encode", "endswith",
    "error", "eval", "exception", "exec", "exit", "fatal", "find", "float", "fromisoformat",
    "get_logger", "getLogger", "import_module", "index", "info", "input", "int", "intern",
    "itemgetter",
    "log", "lstrip", "make_dataclass", "maketrans", "methodcaller", "namedtuple", "open", "ord",
    "partition", "print", "read", "read_text", "removeprefix", "removesuffix", "replace", "rfind",
    "rindex", "rpartition", "rsplit", "rstrip", "split", "splitlines", "startswith", "strftime",
    "strip", "strptime", "super", "translate", "type", "warn", "warning", "write", "write_text",
)  # fmt: skip
PLAIN_TEXTS: dict[str, int] = {
    **dict.fromkeys(_NAMES_THINGS, 1),
    **dict.fromkeys(_WITH_TEXTS_OF_ITS_OWN, ALL),
    "getattr": 2, "setattr": 2, "hasattr": 2, "delattr": 2,
    "create_publisher": 2, "create_lifecycle_publisher": 2, "create_subscription": 2,
    "create_service": 2, "create_client": 2, "lookup_transform": 2, "can_transform": 2,
    "ActionClient": 3, "ActionServer": 3,
}  # fmt: skip
"""Functions for which texts in so many leading arguments stay plain: names of things, formats and
what is logged. For `ALL` it is all arguments."""

PLAIN_MODULES = frozenset(
    {"argparse", "ctypes", "getopt", "importlib", "inspect", "json", "locale", "logging", "os",
     "pathlib", "re", "shlex", "shutil", "signal", "socket", "sqlite3", "struct", "subprocess",
     "sys", "tempfile", "threading", "time", "typing", "unittest", "warnings", "yaml"}
)  # fmt: skip
"""Modules whose functions get texts as they are, called by the module's name."""

PLAIN_KEYWORDS = frozenset(
    {"casting", "dtype", "encoding", "errors", "indexing", "mode", "namespace", "newline",
     "node_name", "order", "topic", "srv_name"}
)  # fmt: skip
"""Keyword arguments whose texts stay plain."""

_FAILURES = ("Error", "Exception", "Warning", "Interrupt", "Exit")

RUN_ONCE = frozenset({"__init__", "__post_init__", "__new__"})
"""Methods that run once for each object (`LiteralInfo.repeated`)."""

RETURNS_PLAIN = frozenset(
    {"__int__", "__index__", "__float__", "__complex__", "__trunc__", "__len__", "__length_hint__",
     "__hash__", "__sizeof__", "__repr__", "__str__", "__format__", "__fspath__"}
)  # fmt: skip
"""Methods from which Python wants an exact number or text (a subclass is deprecated or pointless).
"""

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


def plain_texts(callee: str | None, module: str | None) -> int:
    """In how many leading arguments texts stay plain; `ALL`: in keyword arguments too.

    callee  the last name of what is called
    module  the first one, if it is called by a dotted name
    """
    if callee is None:
        return 0
    if module in PLAIN_MODULES or callee.endswith(_FAILURES):
        return ALL
    return PLAIN_TEXTS.get(callee, 0)


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
