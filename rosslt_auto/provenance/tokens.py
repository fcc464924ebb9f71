"""Parameter names of sources that are no literals (contract: Locations and parameters)."""

from __future__ import annotations

import os
import re
import sys
from types import FrameType

_FORBIDDEN = re.compile(r"[^A-Za-z0-9_]")
_OWN = __name__.partition(".")[0] + "."


def token(name: str) -> str:
    """`name` as one token: ``[A-Za-z_][A-Za-z0-9_]*`` without leading double underscores."""
    cleaned = _FORBIDDEN.sub("_", name)
    if cleaned.startswith("__"):
        cleaned = cleaned.removesuffix("__").lstrip("_") or "_"
    return f"_{cleaned}" if cleaned[:1].isdigit() else cleaned or "_"


def module_prefix(frame: FrameType) -> str:
    """``rosslt.<module>`` for the module that a frame runs; a script goes by its file's name."""
    module = frame.f_globals.get("__name__") or "__main__"
    if module in ("__main__", "__mp_main__"):
        stem = os.path.splitext(os.path.basename(frame.f_code.co_filename))[0]
        return f"rosslt.{token(stem)}"
    return ".".join(("rosslt", *map(token, str(module).split("."))))


def calling_frame() -> FrameType | None:
    """The innermost frame that is not of this package."""
    frame: FrameType | None = sys._getframe()
    while frame is not None and str(frame.f_globals.get("__name__")).startswith(_OWN):
        frame = frame.f_back
    return frame
