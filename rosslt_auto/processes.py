"""Processes that a program starts with `multiprocessing`: instrumented as it is itself.

A forked one is a copy. One that is spawned, or comes from a fork server, is a new interpreter that
gets to know its program from ``multiprocessing.spawn.get_preparation_data``, the first join point:
there it is told of us, too. A fork server imports modules before, since 3.14 the program itself; it
is told in the command that starts it, where ``multiprocessing.util.spawnv_passfds`` is the join
point. Values that are sent between processes arrive as plain ones.
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
        for (module, function), advised in _ADVISED.items():
            make = functools.partial(advised, arguments, read_only)
            _points.replace_when_imported(f"multiprocessing.{module}", function, make)


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


def _told_in_data(
    arguments: list[str], read_only: bool, original: Callable[..., Any]
) -> Callable[..., Any]:
    @functools.wraps(original)
    def get_preparation_data(*args: Any, **kwargs: Any) -> Any:
        return original(*args, **kwargs) | {"rosslt_auto": _Told(arguments, read_only)}

    return unseen(get_preparation_data)


def _told_in_command(
    arguments: list[str], read_only: bool, original: Callable[..., Any]
) -> Callable[..., Any]:
    @functools.wraps(original)
    def spawnv_passfds(path: Any, args: Any, *rest: Any, **kwargs: Any) -> Any:
        words = [*args]
        for position, word in enumerate(words):
            if type(word) is str and _FORK_SERVER in word:
                from pickle import dumps

                told = dumps(_Told(arguments, read_only))
                words[position] = f"__import__('pickle').loads({told!r}); {word}"
        return original(path, words, *rest, **kwargs)

    return unseen(spawnv_passfds)


_ADVISED = {
    ("spawn", "get_preparation_data"): _told_in_data,
    ("util", "spawnv_passfds"): _told_in_command,
}
"""What makes the advice, by the module of `multiprocessing` and its function."""

_FORK_SERVER = "from multiprocessing.forkserver import main"


class _Told:
    """Unpickled, it has us installed. Made of builtins alone: we may not be found over there."""

    def __init__(self, arguments: list[str], read_only: bool) -> None:
        self.told = ([one.parts() for one in hook.selections()], arguments, read_only)

    def __reduce__(self) -> Any:
        folder = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
        return exec, (_JOIN, {"folder": folder, "told": self.told})
