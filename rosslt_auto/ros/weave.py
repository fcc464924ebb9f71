"""Puts all aspects around rclpy, in order, as soon as the program has imported it.

A program that imports no rclpy is left alone. This module imports neither rclpy nor wrapt itself:
`run` should start as fast as python does.
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import sys
from collections.abc import Sequence
from types import ModuleType
from typing import Any

from . import overrides

ASPECTS = ("parameters", "declared", "changes", "serving", "publishing", "subscribing")

JOINED = "rclpy.node"
"""The module that imports everything that has join points."""

_read_only = False


def prepare(arguments: Sequence[str], read_only: bool = False) -> None:
    """To be called before the program starts.

    arguments  its command line, for values of literals (`overrides`)
    read_only  shows provenance but refuses every change
    """
    global _read_only
    _read_only = read_only
    overrides.prepare(arguments)
    if JOINED in sys.modules:
        _weave()
    else:
        sys.meta_path.insert(0, _Finder())


class _Finder:
    """Lets everybody else find `JOINED`, once, and sees its import through (PEP 451)."""

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        if name != JOINED:
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        if spec is not None and spec.loader is not None:
            spec.loader = _Loader(spec.loader)  # type: ignore[assignment]
        return spec


class _Loader:
    def __init__(self, loader: Any) -> None:
        self._loader = loader

    def __getattr__(self, name: str) -> Any:
        return getattr(self._loader, name)

    def create_module(self, spec: Any) -> Any:
        return self._loader.create_module(spec)

    def exec_module(self, module: ModuleType) -> None:
        module.__loader__ = self._loader
        if module.__spec__ is not None:
            module.__spec__.loader = self._loader
        self._loader.exec_module(module)
        _weave()


def _weave() -> None:
    try:
        install()
    except Exception as error:
        # Another rclpy than the ones we know: the program runs plain.
        with contextlib.suppress(Exception):
            uninstall()
        print(f"rosslt_auto: no provenance, rclpy is not as expected: {error!r}", file=sys.stderr)


def install() -> None:
    """Weaves all aspects, once. Imports rclpy."""
    for name in ASPECTS:
        aspect: Any = importlib.import_module(f"{__package__}.{name}")
        if name == "parameters":
            aspect.read_only = _read_only
        aspect.install()


def uninstall() -> None:
    """Takes all advice off, last first."""
    for name in reversed(ASPECTS):
        aspect = sys.modules.get(f"{__package__}.{name}")
        if aspect is not None:
            aspect.uninstall()
