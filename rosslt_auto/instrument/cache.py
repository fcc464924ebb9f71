"""Rewritten code kept on disk, beside Python's own cache (PEP 3147) under a tag of its own.

An entry is valid for one source text - by its hash, as PEP 552 has it, not by its time - and for
one version of the rewriter. It is written like CPython writes its own: to a temporary name, then
moved; where that is not possible, nothing is written. A bad entry counts as none.
"""

from __future__ import annotations

import contextlib
import importlib.util
import marshal
import os
import sys
import zlib
from importlib.machinery import BYTECODE_SUFFIXES
from types import CodeType
from typing import NamedTuple

from ..provenance.locations import fingerprint

FORMAT = 3
"""Changes with the layout of entries; changes of the rewriter are noticed by themselves."""

INTERPOLATIONS = "+"
"""What the name of a module's table is followed by in the name of its list of f-strings."""

_CHECKED_HASH = (0b11).to_bytes(4, "little")  # PEP 552: flags of a checked hash-based pyc
_ENGINE_FILES = (
    "plain.py", "naming.py", "arithmetic.py", "operations.py", "calls.py", "file_calls.py",
    "statistics_calls.py", "call_sites.py", "walk.py", "interpolations.py", "remarks.py",
    "statements.py", "expressions.py", "rewriter.py",
    os.path.join(os.pardir, "provenance", "tokens.py"),
    os.path.join(os.pardir, "provenance", "truth_sites.py"),
)  # fmt: skip


class Entry(NamedTuple):
    """Rewritten code and what it needs to run.

    module  the dotted name for which names were given
    path    the source file that it was made from, as it stands in the code's tracebacks
    table   the name of its table of literals
    values  the literals' values
    infos   what is known of each literal, marshalled: it is needed late or never
    parts   what each of its f-strings is made of
    warnings  what is wrong with its remarks
    """

    module: str
    path: str
    table: str
    code: CodeType
    values: tuple
    infos: bytes
    parts: tuple
    warnings: tuple = ()


def path_for(source_path: str) -> str | None:
    """Where the entry for a source file is; None if this Python has no caches."""
    try:
        plain = importlib.util.cache_from_source(source_path)
    except NotImplementedError:
        return None
    stem = plain.removesuffix(BYTECODE_SUFFIXES[0])
    return f"{stem}.rosslt-{FORMAT}{BYTECODE_SUFFIXES[0]}"


def read(cache_path: str, source: bytes, module: str, source_path: str) -> Entry | None:
    """The valid entry at `cache_path`, or None."""
    try:
        with open(cache_path, "rb") as file:
            data = file.read()
        header = _header(source)
        if not data.startswith(header):
            return None
        entry = Entry._make(marshal.loads(memoryview(data)[len(header) :]))
    except (OSError, EOFError, ValueError, TypeError):
        return None
    if entry.module != module or entry.path != source_path or type(entry.code) is not CodeType:
        return None
    return entry


def write(cache_path: str, source: bytes, entry: Entry) -> None:
    """Writes `entry`, unless the user forbade it or the file system does."""
    if sys.dont_write_bytecode:
        return
    data = _header(source) + marshal.dumps(tuple(entry))
    temporary = f"{cache_path}.{os.getpid()}"
    try:
        os.makedirs(os.path.dirname(cache_path), exist_ok=True)
        mode = os.stat(entry.path).st_mode | 0o200
        new = os.open(temporary, os.O_CREAT | os.O_EXCL | os.O_WRONLY, mode & 0o666)
        with open(new, "wb") as file:
            file.write(data)
        os.replace(temporary, cache_path)
    except OSError:
        with contextlib.suppress(OSError):
            os.unlink(temporary)


def table_name(module: str, path: str, source: bytes) -> str:
    """The name of a module's table: no program can write it, no other module has it."""
    return f"@rosslt.{module}.{fingerprint(path, source)}"


def _header(source: bytes) -> bytes:
    return (
        importlib.util.MAGIC_NUMBER
        + _CHECKED_HASH
        + importlib.util.source_hash(source)
        + _engine_hash()
    )


_engine: bytes | None = None


def _engine_hash() -> bytes:
    """A hash of everything that decides what rewritten code looks like."""
    global _engine
    if _engine is None:
        folder = os.path.dirname(__file__)
        crc = FORMAT
        for name in _ENGINE_FILES:
            try:
                with open(os.path.join(folder, name), "rb") as file:
                    crc = zlib.crc32(file.read(), crc)
            except OSError:  # in an archive: FORMAT has to do
                continue
        _engine = crc.to_bytes(4, "little")
    return _engine
