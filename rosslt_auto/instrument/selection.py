"""Which modules are instrumented (contract: `run`).

The program itself - its folder or its package - and whatever a pattern names. Never the standard
library or installed packages unless a pattern names them, and never this package.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from typing import Any

_OWN = __name__.partition(".")[0]
_NEVER = frozenset({"_pylong"})
"""Of what it returns, the interpreter changes the sign in place."""

_INSTALLED = (f"{os.sep}site-packages{os.sep}", f"{os.sep}dist-packages{os.sep}")
_STDLIB = tuple(
    dict.fromkeys(path + os.sep for path in (os.path.dirname(os.__file__),
                                             os.path.realpath(os.path.dirname(os.__file__))))
)  # fmt: skip


class Selection:
    """Selects modules by dotted name and by file.

    patterns  fnmatch patterns of dotted names that are selected wherever they come from
    excludes  fnmatch patterns of dotted names that are never selected; they win over all else
    folder    the program's folder: what lies in it is selected, save installed packages in it
    package   the program's package, wherever it is installed
    """

    def __init__(
        self,
        patterns: Iterable[str] = (),
        excludes: Iterable[str] = (),
        folder: str | None = None,
        package: str | None = None,
    ) -> None:
        self.patterns = tuple(patterns)
        self.excludes = tuple(excludes)
        self.folder = folder
        self.package = package
        # A module's __file__ may go through symbolic links or not: both spellings are the folder.
        self._folders = tuple(
            dict.fromkeys(os.path.join(path, "") for path in (folder, os.path.realpath(folder)))
            if folder
            else ()
        )

    def __repr__(self) -> str:
        return (
            f"Selection(patterns={self.patterns}, excludes={self.excludes}, "
            f"folder={self.folder!r}, package={self.package!r})"
        )

    def parts(self) -> tuple[Any, ...]:
        """What it is made of."""
        return self.patterns, self.excludes, self.folder, self.package

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Selection) and vars(self) == vars(other)

    def __hash__(self) -> int:
        return hash((self.patterns, self.excludes, self.folder, self.package))

    def selects(self, name: str, path: str) -> bool:
        """Whether the module `name`, loaded from the source file `path`, is instrumented."""
        if self._matches(name, self.excludes) or _within(name, _OWN) or name in _NEVER:
            return False
        if self._matches(name, self.patterns):
            return True
        if not self._folders and self.package is None:
            return False
        if is_stdlib(path):
            return False
        if self.package is not None and _within(name, self.package):
            return True
        return any(
            path.startswith(folder) and not is_installed(path, len(folder) - 1)
            for folder in self._folders
        )

    @staticmethod
    def _matches(name: str, patterns: tuple[str, ...]) -> bool:
        if not patterns:
            return False
        from fnmatch import fnmatchcase  # not needed by most, and slow to import

        return any(fnmatchcase(name, pattern) for pattern in patterns)

    def with_folder(self, folder: str) -> Selection:
        """The same, for the program in `folder`."""
        return Selection(self.patterns, self.excludes, folder, self.package)

    def with_package(self, package: str) -> Selection:
        """The same, for the program in `package`."""
        return Selection(self.patterns, self.excludes, self.folder, package)

    def with_script(self, path: str) -> Selection:
        """The same, for the script at `path`: its folder, or the package that it stands in."""
        return self.with_folder(folder_of(path))


def folder_of(path: str) -> str:
    """The folder that a script belongs to: the outermost package's, else its own."""
    folder = os.path.dirname(os.path.realpath(path))
    while _is_package(folder) and _is_package(parent := os.path.dirname(folder)):
        if parent == folder:
            break
        folder = parent
    return folder


def _is_package(folder: str) -> bool:
    return os.path.isfile(os.path.join(folder, "__init__.py"))


def _within(name: str, package: str) -> bool:
    return name == package or name.startswith(package + ".")


def is_stdlib(path: str) -> bool:
    return path.startswith(_STDLIB) and not is_installed(path)


def is_installed(path: str, start: int = 0) -> bool:
    return any(path.find(part, start) >= 0 for part in _INSTALLED)
