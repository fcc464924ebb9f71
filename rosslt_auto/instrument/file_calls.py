"""Calls that read YAML and JSON files, made by rewritten code: ``@rosslt.file(yaml.safe_load, f)``.

The plain function does the work; only what it returns is looked at afterwards (`provenance.files`).
Which function it is, is decided by the function object, when it is called. A module that the
program has not imported is not imported here.
"""

from __future__ import annotations

import builtins
import io
import os
import sys
from collections import OrderedDict
from collections.abc import Callable
from types import FunctionType, MethodType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.values import untracked

CALL_FILE = "@rosslt.file"
"""The name under which rewritten code finds `call_file`, in `builtins`."""

FILE_CALLS = frozenset(
    {"load", "loads", "safe_load", "full_load", "unsafe_load", "read", "read_text"}
)
"""Names of functions and methods that the rewriter lets go through `call_file`."""

_MODULES = ("json", "yaml")
_REMEMBERED = 64

_texts: OrderedDict[tuple[int, int], tuple[str, str]] = OrderedDict()
"""Path and encoding of texts that were read, by hash and length: no text is kept alive."""


@unseen
def call_file(function: Callable[..., Any], /, *args: Any, **keywords: Any) -> Any:
    """``function(*args, **keywords)``; what was read from a file is tracked."""
    return _looked_at(function, args, keywords, function(*args, **keywords))


def publish() -> None:
    """Lets rewritten code find `call_file`."""
    setattr(builtins, CALL_FILE, call_file)


def _looked_at(function: Any, args: Any, keywords: Any, value: Any) -> Any:
    """`value`, tracked if the call was one of those in `ADVICE`. Raises nothing."""
    try:
        advice = ADVICE.get(_name(function))
        return value if advice is None else advice(value, function, args, keywords)
    except Exception:
        import logging

        logging.getLogger(__name__).debug("what was read is not tracked", exc_info=True)
        return value


def _name(function: Any) -> str:
    """The key in `ADVICE` for a function object, "" for one that is not known."""
    kind = type(function)
    if kind is FunctionType:
        module = function.__globals__.get("__name__")
        if module in _MODULES and vars(sys.modules[module]) is function.__globals__:
            known = function.__globals__.get(function.__name__) is function
            return f"{module}.{function.__name__}" if known else ""
    elif kind is MethodType:
        pathlib = sys.modules.get("pathlib")
        if pathlib is not None and function.__func__ is pathlib.Path.read_text:
            return "Path.read_text"
        return ""
    elif kind is type(len) and type(function.__self__) is io.TextIOWrapper:
        return f"file.{function.__name__}"
    return ""


# ---------------------------------------------------------------- texts that were read


def _file_read(value: Any, function: Any, args: Any, keywords: Any) -> Any:
    found = _real_file(function.__self__)
    if found is not None and type(value) is str:
        _remember(value, *found)
    return value


def _path_read(value: Any, function: Any, args: Any, keywords: Any) -> Any:
    import locale

    encoding = args[0] if args else keywords.get("encoding")
    path = os.path.abspath(untracked(os.fspath(function.__self__)))
    _remember(value, path, untracked(encoding) or locale.getpreferredencoding(False))
    return value


def _remember(text: str, path: str, encoding: str) -> None:
    _texts[hash(text), len(text)] = path, encoding
    while len(_texts) > _REMEMBERED:
        _texts.popitem(last=False)


def _real_file(file: Any) -> tuple[str, str] | None:
    """Path and encoding of an open file on disk, None for anything else."""
    if type(file) is io.TextIOWrapper:
        binary, encoding = file.buffer, file.encoding
    else:
        binary, encoding = file, ""
    if type(binary) not in (io.BufferedReader, io.BufferedRandom):
        return None
    raw = binary.raw
    if type(raw) is not io.FileIO or not isinstance(raw.name, (str, bytes)):
        return None
    path = os.path.abspath(untracked(os.fsdecode(raw.name)))
    if not os.path.samestat(os.fstat(raw.fileno()), os.stat(path)):
        return None  # the name is not its name any more
    return path, encoding


# ---------------------------------------------------------------- loaders


def _loaded(value: Any, given: Any, language: str, loader: Any = None) -> Any:
    """What was loaded from `given`, a file or a text."""
    from ..provenance.files import track
    from ..provenance.tokens import calling_frame

    given = untracked(given)
    text = given if type(given) is str else None
    found = _texts.get((hash(given), len(given))) if text is not None else _real_file(given)
    if found is None:
        return value
    path, encoding = found
    with io.open_code(path) as file:
        content = file.read()
    frame = calling_frame()
    if frame is None:
        return value
    return track(value, path, content, encoding or "utf-8", language, frame, loader, text)


def _json(value: Any, function: Any, args: Any, keywords: Any) -> Any:
    pairs = keywords.pop("object_pairs_hook", None)
    given = args[0] if args else keywords.pop("fp" if function.__name__ == "load" else "s", None)
    if pairs not in (None, dict, OrderedDict) or any(
        one is not None for name, one in keywords.items() if name != "strict"
    ):
        return value  # its own ideas of what an object or a number is
    return _loaded(value, given, "json")


def _yaml(value: Any, function: Any, args: Any, keywords: Any) -> Any:
    import yaml

    from ..provenance.file_positions import is_known_loader

    names = {"safe_load": "SafeLoader", "full_load": "FullLoader", "unsafe_load": "UnsafeLoader"}
    given = {**dict(zip(("stream", "Loader"), args, strict=False)), **keywords}
    loader = given.get("Loader") or getattr(yaml, names[function.__name__])
    if not is_known_loader(loader):
        return value
    return _loaded(value, given.get("stream"), "yaml", loader)


ADVICE: dict[str, Callable[[Any, Any, Any, Any], Any]] = {
    "json.load": _json,
    "json.loads": _json,
    "yaml.load": _yaml,
    "yaml.safe_load": _yaml,
    "yaml.full_load": _yaml,
    "yaml.unsafe_load": _yaml,
    "file.read": _file_read,
    "Path.read_text": _path_read,
}
"""What is done with the result of a function: (value, function, args, keywords) -> value."""
