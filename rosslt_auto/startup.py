"""``ROSSLT_AUTO_MODULES=pattern,...``: instruments Python processes that others start.

A launch file starts nodes as it always does; with this variable in its environment, those that
match become what ``python -m rosslt_auto run`` makes of them. `begin` is called by a line in
``rosslt_auto.pth`` (see the documentation of `site`) at the start of every interpreter that finds
this package installed, and only where the variable is set.

A pattern with a slash matches the path of a script, any other one dotted names of modules (a
console script is one that imports its package) and names of scripts without ``.py``. Modules are
instrumented when they are imported. A script is not imported: ``run`` takes the place of its
process, with the same process id, arguments and interpreter options.
"""

from __future__ import annotations

import os
import re
import sys
from typing import Any

VARIABLE = "ROSSLT_AUTO_MODULES"

_OWN = "rosslt_auto"


def patterns() -> list[str]:
    """What the variable says."""
    found = [pattern.strip() for pattern in os.environ.get(VARIABLE, "").split(",")]
    return [pattern for pattern in found if pattern]


def begin() -> None:
    """Prepares a process that has just been started. May not return."""
    wanted = patterns()
    kind, name = _program()
    if not wanted or os.path.basename(name).partition(".")[0] == _OWN:
        return  # our own command line reads the variable itself
    if kind == "script" and matches_script(name, wanted):
        _run_instead()
    sys.meta_path.insert(0, _Finder(wanted))


def matches_script(path: str, wanted: list[str]) -> bool:
    """Whether one of the patterns means the script at `path`."""
    from fnmatch import fnmatchcase

    paths = {os.path.abspath(path), os.path.realpath(path)}
    stem = os.path.basename(path).removesuffix(".py")
    return any(
        any(fnmatchcase(one, pattern) for one in (paths if "/" in pattern else (stem,)))
        for pattern in wanted
    )


def _program() -> tuple[str, str]:
    """What is started: ("script", path), ("module", name), or ("", "") for anything else."""
    arguments = getattr(sys, "argv", None) or [""]
    first = arguments[0]
    if first == "-m":  # the name stands before the program's own arguments
        word = sys.orig_argv[len(sys.orig_argv) - len(arguments)]
        return "module", word.removeprefix("-m")
    return ("", "") if first in ("", "-", "-c") else ("script", first)


def _run_instead() -> None:
    """Replaces this process by one in which ``run`` runs its script."""
    if not sys.executable:
        return
    options = sys.orig_argv[1 : len(sys.orig_argv) - len(sys.argv)]
    command = [sys.orig_argv[0], *options, "-m", _OWN, "run", "--", *sys.argv]
    os.execv(sys.executable, command)


class _Finder:
    """Finds nothing, but sees when the first module that matches is looked for (PEP 451)."""

    def __init__(self, wanted: list[str]) -> None:
        from fnmatch import translate  # not below: that would be looked for here

        self._wanted = wanted
        self._matches = re.compile("|".join(map(translate, wanted))).match

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> None:
        if self not in sys.meta_path or name.partition(".")[0] == _OWN:
            return
        if self._matches(name):
            sys.meta_path.remove(self)
            try:
                _install(self._wanted)
            except Exception as error:
                print(f"rosslt_auto: a process runs without provenance: {error}", file=sys.stderr)


def _install(wanted: list[str]) -> None:
    from . import processes
    from .instrument import subinterpreters
    from .instrument.selection import Selection

    if not subinterpreters.is_one():
        processes.join([Selection(wanted).parts()], sys.argv[1:], read_only=False)
        subinterpreters.install()
