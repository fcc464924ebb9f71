"""What Python says of a script that it cannot read as source.

Of a file it says something else than of the same bytes in memory, which is what `compile` gets
(CPython's `Parser/tokenizer.c`).
"""

from __future__ import annotations

import io
import re
import sys
import tokenize

_NOT_DECLARED = (
    "Non-UTF-8 code starting with '\\x{:02x}' in file {} on line {}, but no encoding declared; "
    "see https://peps.python.org/pep-0263/ for details"
)

_COOKIE = re.compile(rb"[ \t\f]*#.*?coding[:=][ \t]*([-\w.]+)")
"""As PEP 263 has it; `tokenize` has it for texts, and since 3.14 for bytes."""


def as_of_file(error: SyntaxError, source: bytes, path: str) -> SyntaxError:
    """The error that the interpreter has for the file where `compile` has `error`."""
    cookie = _cookie(source)
    if error.lineno == 0 and not str(error.msg).startswith("encoding problem"):
        return SyntaxError(f"encoding problem: {cookie}")
    if error.lineno == 0:
        return SyntaxError(error.msg)
    if cookie is None and not source.startswith(b"\xef\xbb\xbf"):
        for number, line in enumerate(source.split(b"\n"), 1):
            try:
                line.decode()
            except UnicodeDecodeError as wrong:
                message = _NOT_DECLARED.format(line[wrong.start], path, number)
                if sys.version_info < (3, 14):
                    return SyntaxError(message)
                error.msg = message  # where, it says itself
                return error
    if b"\0" in source:
        return _null_byte(source, path)
    return error


def _null_byte(source: bytes, path: str) -> SyntaxError:
    before = source[: source.index(b"\0")]
    line = before.rpartition(b"\n")[2].decode("utf-8", "replace")
    number = before.count(b"\n") + 1
    return SyntaxError("source code cannot contain null bytes", (path, number, None, line))


def _cookie(source: bytes) -> str | None:
    """The encoding that the file declares (PEP 263), None if it does not."""
    for line in io.BytesIO(source).readlines()[:2]:
        found = _COOKIE.match(line)
        if found:
            return found[1].decode()
        if not tokenize.blank_re.match(line):
            return None
    return None
