"""Console scripts: wrappers in a ``bin`` folder that import the real package and call it.

Running such a wrapper means running that package. Recognised by what installers write: pip and
setuptools (``from pkg.module import main``), and setup.py install or develop
(``load_entry_point``), which is what ROS 2's build tools leave in ``lib/<package>/``.
"""

from __future__ import annotations

import ast
import re
import sys

_ENTRY_POINT = re.compile(
    rb"EASY-INSTALL-ENTRY-SCRIPT: *'([^'=]+)(?:==[^']*)?' *, *'([^']+)' *, *'([^']+)'"
)
_LONGEST = 8192  # wrappers are short


def wrapped_package(source: bytes) -> str | None:
    """The top-level package that a console script belongs to; None if `source` is none."""
    if len(source) > _LONGEST:
        return None
    found = _ENTRY_POINT.search(source)
    if found:
        return _package_of_entry_point(*(part.decode() for part in found.groups()))
    return _package_of_wrapper(source)


def _package_of_entry_point(distribution: str, group: str, name: str) -> str | None:
    from importlib.metadata import PackageNotFoundError, entry_points

    try:
        found = entry_points(group=group, name=name)
    except PackageNotFoundError:
        return None
    for entry in found:
        if entry.dist is None or _normal(entry.dist.name) == _normal(distribution):
            return entry.module.partition(".")[0]
    return None


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def _package_of_wrapper(source: bytes) -> str | None:
    """What `main` comes from in: imports, then ``if __name__ == "__main__": sys.exit(main())``."""
    try:
        body = ast.parse(source).body
    except (SyntaxError, ValueError):
        return None
    imports = [s for s in body if isinstance(s, (ast.Import, ast.ImportFrom))]
    rest = [s for s in body if s not in imports]
    if len(rest) != 1 or not isinstance(rest[0], ast.If):
        return None
    called = {
        node.func.id
        for node in ast.walk(rest[0])
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    } | {
        node.func.value.id
        for node in ast.walk(rest[0])
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and isinstance(node.func.value, ast.Name)
    }
    for statement in imports:
        if isinstance(statement, ast.ImportFrom) and statement.module and not statement.level:
            package = statement.module.partition(".")[0]
            names = {alias.asname or alias.name for alias in statement.names}
            if names & called and package not in sys.stdlib_module_names:
                return package
    return None
