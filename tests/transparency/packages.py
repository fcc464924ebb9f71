"""Packages from the package index as cases.

Of the suite "packages" a whole package is instrumented, and its own tests run. Tests come with the
source distribution, the package as it is installed everywhere. Of the suite "extensions" a program
is instrumented that uses packages. All is fetched once, by pip, into the folder of things that are
made (`running.BUILD`).
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import shutil
import subprocess
import sys
import tarfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from transparency.running import BUILD
from transparency.suites import Case, expected, table

_PATIENCE = 300.0
_PROGRAMS = Path(__file__).parent / "data" / "extensions"


class NotFetched(Exception):
    """A package could not be downloaded or installed; the message says why."""


def cases() -> Iterator[Case]:
    """A case for each package in the table; its files may still have to be fetched."""
    table_ = table("packages")
    for name, row in table_["packages"].items():
        source, installed = _folders(name, row)
        yield Case(
            "packages", name, "record_pytest",
            ["-o", "addopts=", *row.get("options", []), *row["tests"]],
            [pattern for module in row["modules"] for pattern in (module, f"{module}.*")],
            row.get("excluded", []),
            folder=source,
            path=[installed],
            timeout=row.get("timeout", 200.0),
            printed=False,  # pytest's dots and times; what the tests print, it has caught
            expected=expected(table_.get("expected", {}), name),
            prepare=lambda name=name, row=row: fetch(name, row),
        )  # fmt: skip


def callers() -> Iterator[Case]:
    """A case for each program that calls extensions; its packages may still have to be fetched."""
    for name, needs in table("extensions")["programs"].items():
        folder = _folder(name, needs)
        yield Case(
            "extensions", name, "", [str(_PROGRAMS / f"{name}.py")], ["__main__"],
            path=[folder / "installed"],
            prepare=lambda needs=needs, folder=folder: _install(folder, needs),
        )  # fmt: skip


def _install(folder: Path, needs: list[str]) -> None:
    with _once(folder) as missing:
        if missing:
            _pip("install", "--target", str(folder / "installed"), *needs)


def fetch(name: str, row: dict) -> None:
    """Downloads and installs what a row of the table says. Raises NotFetched."""
    source, installed = _folders(name, row)
    with _once(source.parent) as missing:
        if missing:
            requirement = f"{name}=={row['version']}"
            _download(name, requirement, source)
            _pip("install", "--target", str(installed), requirement, *row.get("needs", []))


def _download(name: str, requirement: str, source: Path) -> None:
    folder = source.parent
    _pip("download", "--no-deps", "--no-binary", name, "--dest", str(folder), requirement)
    [archive] = folder.glob("*.tar.gz")
    with tarfile.open(archive) as files:
        files.extractall(folder / "unpacked", filter="data")
    [unpacked] = (folder / "unpacked").iterdir()
    unpacked.rename(source)


@contextlib.contextmanager
def _once(folder: Path) -> Iterator[bool]:
    """Whether a folder has to be filled still: it is complete when that has ended well."""
    missing = not (folder / "complete").exists()
    if missing:
        shutil.rmtree(folder, ignore_errors=True)
    yield missing
    if missing:
        (folder / "complete").touch()


def _folders(name: str, row: dict) -> tuple[Path, Path]:
    """Where the unpacked source distribution and the installed package are."""
    folder = _folder(f"{name}-{row['version']}", [row["version"], row.get("needs", [])])
    return folder / "source", folder / "installed"


def _folder(name: str, asked: Any) -> Path:
    """Where all of what a table asks for is kept, for this version of Python."""
    key = hashlib.sha256(json.dumps([asked, sys.version_info[:2]]).encode()).hexdigest()[:10]
    return BUILD / "packages" / f"{name}-{key}"


def _pip(*arguments: str) -> None:
    command = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE)
    except subprocess.TimeoutExpired:
        raise NotFetched(f"no answer within {_PATIENCE:g} s") from None
    if done.returncode:
        raise NotFetched((done.stderr.strip().splitlines() or ["pip failed"])[-1])
