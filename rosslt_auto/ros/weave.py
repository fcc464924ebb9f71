"""Puts all aspects around rclpy, in order, as soon as the program has imported it.

A program that imports no rclpy is left alone. This module imports neither rclpy nor wrapt itself:
`run` should start as fast as python does.
"""

from __future__ import annotations

import contextlib
import importlib
import sys
from collections.abc import Sequence
from typing import Any

from ..provenance.joinpoints import JoinPoints
from . import overrides

ASPECTS = ("parameters", "declared", "changes", "serving", "publishing", "subscribing")

JOINED = "rclpy.node"
"""The module that imports everything that has join points."""

_read_only = False
_points = JoinPoints()


def prepare(arguments: Sequence[str], read_only: bool = False) -> None:
    """To be called before the program starts.

    arguments  its command line, for values of literals (`overrides`)
    read_only  shows provenance but refuses every change
    """
    global _read_only
    _read_only = read_only
    overrides.prepare(arguments)
    if not _points:
        _points.when_imported(JOINED, _weave)


def is_prepared() -> bool:
    """Whether the aspects are woven, or will be."""
    return bool(_points)


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
    """Takes all advice off, last first, and waits for rclpy no longer."""
    _points.restore()
    for name in reversed(ASPECTS):
        aspect = sys.modules.get(f"{__package__}.{name}")
        if aspect is not None:
            aspect.uninstall()
