"""Subinterpreters (PEP 554, PEP 684) run plain, and that is said once.

Each has modules, builtins and import hooks of its own, and rclpy's extensions cannot be loaded in
most. What is handed over to one arrives as a plain value, see `exact_types`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from importlib import import_module
from typing import Any

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints
from .hook import warn_once

MODULES = ("_xxsubinterpreters", "_interpreters")
"""Which one there is depends on the version: up to 3.12, from 3.13 on."""

MESSAGE = "rosslt_auto: subinterpreters run without provenance"

_points = JoinPoints()


def is_one() -> bool:
    """Whether this code runs in a subinterpreter."""
    for name in MODULES:
        try:
            interpreters: Any = import_module(name)
        except ImportError:
            continue
        return bool(interpreters.get_current() != interpreters.get_main())
    return False


def refuses() -> bool:
    """The same, said once if it is so."""
    if is_one():
        warn_once(MESSAGE, MESSAGE)
        return True
    return False


def install() -> None:
    """Says it when the first one is made. Idempotent."""
    if not _points:
        for module in MODULES:
            _points.replace_when_imported(module, "create", _advised)


def uninstall() -> None:
    """Takes the advice off again."""
    _points.restore()


def _advised(original: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(original)
    def create(*args: Any, **kwargs: Any) -> Any:
        made = original(*args, **kwargs)
        warn_once(MESSAGE, MESSAGE)
        return made

    return unseen(create)
