"""What `force` has changed, so that it can be taken back: one line of JSON per force.

Kept in the user's state folder (XDG Base Directory Specification), one file per ROS domain: a node
called /talker in another domain is another node.
"""

from __future__ import annotations

import contextlib
import json
import os
from pathlib import Path

from .client import Change

KEPT = 100
"""Forces that can be taken back, one after the other."""


def path() -> Path:
    """The file for this domain."""
    base = os.environ.get("XDG_STATE_HOME") or os.path.expanduser("~/.local/state")
    return Path(base) / "rosslt_auto" / f"changes-{os.environ.get('ROS_DOMAIN_ID') or 0}.jsonl"


def add(changes: list[Change]) -> None:
    """Notes what one force has changed. A folder that cannot be written to keeps nothing."""
    if not changes:
        return
    line = json.dumps([change.to_json() for change in changes])
    with contextlib.suppress(OSError):
        _write([*_lines(), line])


def last() -> list[Change]:
    """What the latest force that has not been taken back has changed; empty if there is none."""
    lines = _lines()
    if not lines:
        return []
    try:
        return [Change(**change) for change in json.loads(lines[-1])]
    except (ValueError, TypeError):
        return []


def drop_last() -> None:
    """Forgets the latest force."""
    _write(_lines()[:-1])


def _lines() -> list[str]:
    try:
        return path().read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeError):
        return []


def _write(lines: list[str]) -> None:
    file = path()
    file.parent.mkdir(parents=True, exist_ok=True)
    new = file.with_name(f"{file.name}.{os.getpid()}")
    new.write_text("".join(f"{line}\n" for line in lines[-KEPT:]), encoding="utf-8")
    os.replace(new, file)
