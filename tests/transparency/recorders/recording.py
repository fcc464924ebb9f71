"""What the recorders share; runs inside of the program that is compared, plain or instrumented.

A recording is a file of findings, a Python literal a line: ``{"test": ..., "what": ..., ...}``. It
is written line by line, so that a program that dies tells how far it came. Nothing here may depend
on modules that can be instrumented: what they make of a finding is what is to be found out.
"""

import os
import sys
from fnmatch import fnmatchcase
from importlib.machinery import ExtensionFileLoader

KEPT = (
    "__main__", "sys", "builtins", "os", "os.path", "posixpath", "io", "abc", "codecs",
    "encodings*", "importlib*", "_[!a]*", "_abc", "_ast", "site", "stat", "genericpath",
    "zipimport", "runpy", "threading", "rosslt_auto*", "wrapt*", "record_*", "recording", "numpy*",
    "_pytest*", "pytest*", "pluggy*", "atexit", "marshal", "*_wheels_bootstrapper*",
)  # fmt: skip
"""Modules with state of the whole process, of which there must not be two, and our own."""


def forget(patterns: list[str]) -> None:
    """Lets modules that have been imported before the program began be imported again.

    What starts a program has imported much of the standard library, and only what is imported
    later is instrumented. Done for plain programs as well: there may be two of a class then.
    Extensions have no code to be instrumented, and their functions are known by identity.
    """
    for name, module in list(sys.modules.items()):
        loader = getattr(getattr(module, "__spec__", None), "loader", None)
        if isinstance(loader, ExtensionFileLoader):
            continue
        if any(fnmatchcase(name, pattern) for pattern in KEPT):
            continue
        if any(fnmatchcase(name, pattern) for pattern in patterns):
            del sys.modules[name]


class Recording:
    """Writes findings to a file."""

    def __init__(self, path: str) -> None:
        self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        self._process = os.getpid()

    def add(self, test: str, what: str, **details: object) -> None:
        """Notes that `what` ("ok", "error", "skipped", ...) is the outcome of `test`."""
        if os.getpid() == self._process:  # not the children of a test
            line = ascii({"test": str(test), "what": what, **details})
            os.write(self._file, line.encode() + b"\n")


def raised(error: BaseException, limit: int = 8) -> list[dict]:
    """An exception and those behind it: types, messages, and the positions in their tracebacks."""
    found: list[dict] = []
    seen: set[int] = set()
    link: BaseException | None = error
    while link is not None and id(link) not in seen and len(found) < limit:
        seen.add(id(link))
        found.append(
            {
                "type": f"{type(link).__module__}.{type(link).__qualname__}",
                "message": _message(link),
                "notes": [str(note) for note in getattr(link, "__notes__", ())],
                "frames": _frames(link.__traceback__),
            }
        )
        link = link.__cause__ or (None if link.__suppress_context__ else link.__context__)
    return found


def _message(error: BaseException) -> str:
    try:
        return str(error)
    except Exception as second:
        return f"<str() raises {type(second).__name__}>"


def _frames(trace: object) -> list[list]:
    frames = []
    while trace is not None:
        code = trace.tb_frame.f_code  # type: ignore[attr-defined]
        positions = list(code.co_positions())
        index = trace.tb_lasti // 2  # type: ignore[attr-defined]
        place = positions[index] if 0 <= index < len(positions) else (None,) * 4
        frames.append([code.co_filename, code.co_name, trace.tb_lineno, *place])  # type: ignore[attr-defined]
        trace = trace.tb_next  # type: ignore[attr-defined]
    return frames
