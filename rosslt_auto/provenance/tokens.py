"""Tokens of parameter names, and the names of sources that are no literals.

(Contract: Locations and parameters. Names of literals are given in `instrument.naming`.)
"""

from __future__ import annotations

import os
import re
from sys import _getframe
from types import FrameType

_FORBIDDEN = re.compile(r"[^A-Za-z0-9_]")
_OWN = __name__.partition(".")[0] + "."


def token(name: str) -> str:
    """`name` as one token: ``[A-Za-z_][A-Za-z0-9_]*`` without leading double underscores."""
    cleaned = _FORBIDDEN.sub("_", name)
    if cleaned.startswith("__"):
        cleaned = cleaned.removesuffix("__").lstrip("_") or "_"
    return f"_{cleaned}" if cleaned[:1].isdigit() else cleaned or "_"


def module_tokens(module: str, path: str) -> str:
    """The dotted middle of the names for a module; a script goes by its file's name."""
    if module in ("__main__", "__mp_main__"):
        return token(os.path.splitext(os.path.basename(path))[0])
    return ".".join(map(token, module.split(".")))


def module_prefix(frame: FrameType) -> str:
    """``rosslt.<module>`` for the module that a frame runs."""
    module = str(frame.f_globals.get("__name__") or "__main__")
    return f"rosslt.{module_tokens(module, frame.f_code.co_filename)}"


def calling_frame() -> FrameType | None:
    """The innermost frame that is not of this package."""
    frame: FrameType | None = _getframe()
    while frame is not None and str(frame.f_globals.get("__name__")).startswith(_OWN):
        frame = frame.f_back
    return frame
