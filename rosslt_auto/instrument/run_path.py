"""Join point: what `runpy.run_path` compiles, which passes no loader.

`runpy` is not imported here for a program that does without.
"""

from __future__ import annotations

import functools
import marshal
import os
import sys
from collections.abc import Callable
from importlib.util import MAGIC_NUMBER
from types import CodeType, FrameType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints

_points = JoinPoints()


def install() -> None:
    """Wraps the function as soon as `runpy` is imported. Idempotent."""
    if not _points:
        _points.replace_when_imported("runpy", "_get_code_from_file", _advised)


def uninstall() -> None:
    """The function is as it was, save where somebody else has wrapped it since."""
    _points.restore()


def _advised(original: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(original)
    def get_code(*args: Any, **kwargs: Any) -> Any:
        code = None if kwargs else _advice(args)
        if code is None:
            return original(*args, **kwargs)
        return (code, args[1]) if len(args) == 2 else code  # (name, path) before 3.13

    return unseen(get_code)


def _run_name() -> str:
    """The name that a program gets from `run_path`, which since 3.13 does not pass it on."""
    frame: FrameType | None = sys._getframe()
    while frame is not None and frame.f_code.co_name != "run_path":
        frame = frame.f_back
    name = frame.f_locals.get("run_name") if frame is not None else None
    return name if type(name) is str else "<run_path>"


def _advice(args: tuple[Any, ...]) -> CodeType | None:
    """Instrumented code, or None if the plain function is to be called. Raises nothing."""
    from . import hook

    try:
        path = os.fsdecode(args[-1])
        name = args[0] if len(args) == 2 else _run_name()
        if not hook.selects(name, os.path.abspath(path)):
            return None
        with open(path, "rb") as file:
            source = file.read()
        if source.startswith(MAGIC_NUMBER):
            from .code_objects import instrumented_or_same

            return instrumented_or_same(marshal.loads(memoryview(source)[16:]), name)
        return hook.instrumented_or_none(name, path, source, cached=False)
    except Exception:
        return None  # whatever it is, the plain function meets it again
