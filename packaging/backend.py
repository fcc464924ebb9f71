"""Builds as setuptools does (PEP 517, PEP 660), and puts ``rosslt_auto.pth`` into the wheel.

It is what makes Python processes look at ``ROSSLT_AUTO_MODULES`` when they start, see
`rosslt_auto.startup`; setuptools itself has no way to install such a file, least of all with an
editable installation.
"""

from __future__ import annotations

import base64
import hashlib
import os
import shutil
import zipfile
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import *  # noqa: F403  (all other hooks are those of setuptools)

HOOK = os.path.join(os.path.dirname(os.path.abspath(__file__)), "rosslt_auto.pth")


def build_wheel(wheel_directory: str, *args: Any, **kwargs: Any) -> str:
    return _with_hook(wheel_directory, build_meta.build_wheel(wheel_directory, *args, **kwargs))


def build_editable(wheel_directory: str, *args: Any, **kwargs: Any) -> str:
    return _with_hook(wheel_directory, build_meta.build_editable(wheel_directory, *args, **kwargs))


def _with_hook(folder: str, name: str) -> str:
    add(os.path.join(folder, name), HOOK)
    return name


def add(wheel: str, file: str) -> None:
    """Adds a file to the root of a wheel, and to its RECORD."""
    with open(file, "rb") as source:
        content = source.read()
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
    name = os.path.basename(file)
    with zipfile.ZipFile(wheel) as old, zipfile.ZipFile(f"{wheel}.new", "w") as new:
        for entry in old.infolist():
            data = old.read(entry)
            if entry.filename.endswith(".dist-info/RECORD"):
                new.writestr(name, content, zipfile.ZIP_DEFLATED)
                data += f"{name},sha256={digest},{len(content)}\n".encode()
            new.writestr(entry, data, zipfile.ZIP_DEFLATED)
    shutil.move(f"{wheel}.new", wheel)
