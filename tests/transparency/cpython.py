"""CPython's own tests (the package `test` of the interpreter) and programs as cases."""

from __future__ import annotations

import importlib.util
import inspect
import sys
from collections.abc import Iterator
from fnmatch import fnmatchcase
from pathlib import Path

from transparency.suites import Case, expected, table


def cases(suite: str) -> Iterator[Case]:
    """The cases of the suites "programs", "library" and "numbers".

    None of the latter two where Python came without its tests.
    """
    if suite == "programs":
        yield from _programs()
        return
    found = importlib.util.find_spec("test")
    if (
        found is None
        or found.origin is None
        or not Path(found.origin).with_name("support").is_dir()
    ):
        return
    rows = table(suite)
    for name in _names(rows, Path(found.origin).parent):
        yield Case(
            suite, name, "record_unittest", [f"test.{name}"],
            list(_patterns(rows["modules"], name)),
            rows.get("excluded", []),
            timeout=rows.get("timeout", 120.0),
            expected=[*expected(rows.get("expected", {}), name),
                      *expected(rows.get("sometimes", {}), name, always=False)],
        )  # fmt: skip


def _programs() -> Iterator[Case]:
    rows = table("programs")
    for name, arguments in rows["programs"].items():
        where = {"folder": Path(__file__).parent / "data", "library": Path(inspect.__file__).parent}
        yield Case(
            "programs", name, "", [argument.format(**where) for argument in arguments],
            list(_patterns(rows["modules"], name)),
            expected=expected(rows.get("expected", {}), name),
        )  # fmt: skip


def _patterns(modules: list[str], name: str) -> Iterator[str]:
    """The table's patterns; ``{name}`` is the test module, ``{library}`` the standard library."""
    for pattern in modules:
        if pattern == "{library}":
            for module in sorted(sys.stdlib_module_names):
                yield from (module, f"{module}.*")
        else:
            yield pattern.format(name=name)


def _names(rows: dict, folder: Path) -> list[str]:
    """The test modules that the table names, or all but those that it leaves out."""
    there = {
        path.stem
        for path in folder.glob("test_*")
        if path.suffix == ".py" or (path / "__init__.py").exists()
    }
    if "tests" in rows:
        return [name for name in rows["tests"] if name in there]
    left_out = [pattern for patterns in rows["left_out"].values() for pattern in patterns]
    return sorted(
        name for name in there if not any(fnmatchcase(name, pattern) for pattern in left_out)
    )
