"""Processes that a program starts with `multiprocessing`: instrumented as it is itself.

A forked one is a copy. One that is spawned, or comes from a fork server, is a new interpreter that
gets to know its program from ``multiprocessing.spawn.get_preparation_data``, the join point: there
it is told of us, too. Values that are sent between processes arrive as plain ones.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable
from typing import Any

from .instrument import hook
from .instrument.selection import Selection
from .provenance.frames import unseen
from .provenance.joinpoints import JoinPoints
from .ros import weave

# Executed in a new process, as early as that: nothing of what goes wrong here may end it.
_JOIN = """\
try:
    import sys
    sys.path.append(folder)
    try:
        from rosslt_auto.processes import join
    finally:
        sys.path.remove(folder)
    join(*told)
except Exception as error:
    print(f"rosslt_auto: a process runs without provenance: {error}", file=sys.stderr)
"""

_points = JoinPoints()


def install(arguments: list[str], read_only: bool = False) -> None:
    """Has further processes of this program instrumented like this one. Idempotent.

    arguments, read_only  see `weave.prepare`
    """
    if not _points:
        advised = functools.partial(_advised, arguments, read_only)
        _points.replace_when_imported("multiprocessing.spawn", "get_preparation_data", advised)


def uninstall() -> None:
    """Further processes are plain ones, unless they are forked."""
    _points.restore()


def join(selections: list[Any], arguments: list[str], read_only: bool) -> None:
    """Makes a process that has been started by an instrumented one instrumented as well."""
    if not weave.is_prepared():
        weave.prepare(arguments, read_only=read_only)
    for selection in selections:
        hook.install(Selection(*selection))
    install(arguments, read_only)


def _advised(
    arguments: list[str], read_only: bool, original: Callable[..., Any]
) -> Callable[..., Any]:
    @functools.wraps(original)
    def get_preparation_data(*args: Any, **kwargs: Any) -> Any:
        data = original(*args, **kwargs)
        told = ([one.parts() for one in hook.selections()], arguments, read_only)
        return data | {"rosslt_auto": _Told(told)}

    return unseen(get_preparation_data)


class _Told:
    """Unpickled, it has us installed. Made of builtins alone: we may not be found over there."""

    def __init__(self, told: Any) -> None:
        self.told = told

    def __reduce__(self) -> Any:
        folder = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
        return exec, (_JOIN, {"folder": folder, "told": self.told})
