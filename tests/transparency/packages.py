"""Packages from the package index as cases: the whole package instrumented, its own tests run.

Tests come with the source distribution, the package as it is installed everywhere. Both are
fetched once, by pip, into the folder of things that are made (`running.BUILD`).
"""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
import tarfile
from collections.abc import Iterator
from pathlib import Path

from transparency.running import BUILD
from transparency.suites import Case, expected, table

_PATIENCE = 300.0


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


def fetch(name: str, row: dict) -> None:
    """Downloads and installs what a row of the table says. Raises NotFetched."""
    source, installed = _folders(name, row)
    if (source.parent / "complete").exists():
        return
    shutil.rmtree(source.parent, ignore_errors=True)
    requirement = f"{name}=={row['version']}"
    _pip("download", "--no-deps", "--no-binary", name, "--dest", str(source.parent), requirement)
    [archive] = source.parent.glob("*.tar.gz")
    with tarfile.open(archive) as files:
        files.extractall(source.parent / "unpacked", filter="data")
    [unpacked] = (source.parent / "unpacked").iterdir()
    unpacked.rename(source)
    _pip("install", "--target", str(installed), requirement, *row.get("needs", []))
    (source.parent / "complete").touch()


def _folders(name: str, row: dict) -> tuple[Path, Path]:
    """Where the unpacked source distribution and the installed package are."""
    asked = json.dumps([row["version"], row.get("needs", []), sys.version_info[:2]])
    key = hashlib.sha256(asked.encode()).hexdigest()[:10]
    folder = BUILD / "packages" / f"{name}-{row['version']}-{key}"
    return folder / "source", folder / "installed"


def _pip(*arguments: str) -> None:
    command = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", *arguments]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE)
    except subprocess.TimeoutExpired:
        raise NotFetched(f"no answer within {_PATIENCE:g} s") from None
    if done.returncode:
        raise NotFetched((done.stderr.strip().splitlines() or ["pip failed"])[-1])
