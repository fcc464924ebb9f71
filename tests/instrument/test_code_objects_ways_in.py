"""Ways in which code without source comes into a program."""

import importlib
import py_compile
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from textwrap import dedent
from typing import Any

import pytest

from rosslt_auto.provenance import provenance
from rosslt_auto.provenance.registry import location_of, registered

PROGRAM = """
    import math
    GAIN = 0.5
    def scaled(x, offset=1.5):
        return math.sin(x) * GAIN + offset
    def fails(x):
        y = x + 2.5
        return y / (x - x)
"""


def _compiled(folder: Path, name: str, text: str = PROGRAM) -> Path:
    """Writes a module of which only the ``.pyc`` is left."""
    source = folder / f"{name}.py"
    source.write_text(dedent(text))
    compiled = folder / f"{name}.pyc"
    py_compile.compile(str(source), cfile=str(compiled), doraise=True)
    source.unlink()
    return compiled


def _sources(value: Any) -> list[str]:
    found = provenance(value)
    return [] if found is None else [source.parameter for source in found.sources]


def test_modules_without_source(packages: Callable[..., Path]) -> None:
    folder = packages()
    _compiled(folder, "under_test_compiled")
    module = importlib.import_module("under_test_compiled")
    assert module.__loader__.get_source("under_test_compiled") is None
    value = module.scaled(0.0)
    assert value == 1.5
    assert set(_sources(value)) == {
        "rosslt.under_test_compiled.GAIN",
        "rosslt.under_test_compiled.scaled.offset",
    }
    location_of("rosslt.under_test_compiled.fails.y").change(3.5)
    with pytest.raises(ZeroDivisionError) as error:
        module.fails(1.0)
    assert error.traceback[-1].lineno == 7
    assert not [name for name in vars(module) if "rosslt" in name]


def test_packages_without_source(packages: Callable[..., Path]) -> None:
    folder = packages()
    (folder / "under_test_package").mkdir()
    _compiled(folder / "under_test_package", "__init__", "from .inner import scaled\n")
    _compiled(folder / "under_test_package", "inner")
    module = importlib.import_module("under_test_package")
    assert "rosslt.under_test_package.inner.GAIN" in _sources(module.scaled(0.0))


def test_zip_archives_without_source(
    packages: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = packages()
    compiled = _compiled(folder, "under_test_zipped")
    archive = folder / "archive.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.write(compiled, "under_test_zipped.pyc")
    compiled.unlink()
    monkeypatch.syspath_prepend(str(archive))
    module = importlib.import_module("under_test_zipped")
    assert "rosslt.under_test_zipped.GAIN" in _sources(module.scaled(0.0))


def test_others_stay_plain(packages: Callable[..., Path]) -> None:
    folder = packages()
    _compiled(folder, "other_compiled")
    try:
        module = importlib.import_module("other_compiled")
        assert provenance(module.scaled(0.0)) is None
    finally:
        sys.modules.pop("other_compiled", None)


SCRIPT = """
    import sys, traceback
    x = 0.5
    def f(a, b=2): return [a * b, x]
    def g(n): return 1 / (n - 2)
    print(f(3.0), sys.argv, __name__, sorted(k for k in globals()))
    try: g(2)
    except ZeroDivisionError: traceback.print_exc()
    g(2)
"""


@pytest.mark.parametrize("stale", [False, True])
def test_compiled_scripts_end_as_plain_ones(both: Any, tmp_path: Path, stale: bool) -> None:
    compiled = _compiled(tmp_path, "program", SCRIPT)
    if stale:
        compiled.write_bytes(b"\0\0\0\0" + compiled.read_bytes()[4:])
    plain, ours = both("program.pyc", "argument")
    assert plain.status == 1
    assert ours == plain


def test_compiled_scripts_are_tracked(both: Any, tmp_path: Path) -> None:
    _compiled(
        tmp_path,
        "program",
        "from rosslt_auto import provenance\nx = 0.5\nprint(provenance(x * 2))\n"
        "import runpy\nprint(provenance(runpy.run_path('other.pyc')['y']))\n",
    )
    _compiled(tmp_path, "other", "y = 1.5\n")
    plain, ours = both("program.pyc")
    assert plain.stdout == "None\nNone\n"
    assert ours.stdout == "<provenance of 1.0: x * 2>\n<provenance of 1.5: y>\n"


EXECUTES = """
    def f(a):
        names = {"a": a}
        exec("b = a * 2.5", names)
        return names["b"], eval("a + 1.5")
    exec("GAIN = 0.5")
    TWICE = eval("GAIN * 2.0")
    exec(compile("OFFSET = 0.25", "made.py", "exec"))
    exec("HIDDEN = 4.5", {"__builtins__": {}}, (hidden := {}))
    def many():
        made = [eval(f"{i}.5") for i in range(300)]
        return [type(value) is not float for value in made]
"""


@pytest.mark.parametrize("way", ["source", "code object"])
def test_executed_texts(packages: Callable[..., Path], way: str) -> None:
    name = f"under_test_executes_{way[:4]}"
    if way == "source":
        packages(**{name: EXECUTES})
    else:
        _compiled(packages(), name, EXECUTES)
    module = importlib.import_module(name)
    prefix = f"rosslt.{name}"
    assert _sources(module.GAIN) == [f"{prefix}.executed.GAIN"]
    assert _sources(module.TWICE) == [f"{prefix}.executed.GAIN", f"{prefix}.executed_2.eval"]
    assert _sources(module.OFFSET) == [f"{prefix}.executed_3.OFFSET"]
    assert module.hidden == {"HIDDEN": 4.5}
    assert _sources(module.hidden["HIDDEN"]) == []
    first, second = module.f(2.0)
    assert (first, second) == (5.0, 3.5)
    assert _sources(first) == [f"{prefix}.executed_4.b"]
    location_of(f"{prefix}.executed_4.b").change(3.0)
    assert module.f(2.0)[0] == 6.0
    location = location_of(f"{prefix}.executed.GAIN")
    assert (location.file, location.line, location.column) == ("<string>", 1, 7)
    assert location.literals.content is None  # there is nothing to save to


def test_texts_without_end_are_not_remembered(packages: Callable[..., Path]) -> None:
    packages(under_test_many=EXECUTES)
    before = len(registered())
    tracked = importlib.import_module("under_test_many").many()
    assert len(tracked) == 300
    assert len(registered()) - before < 300


def test_equal_code_of_different_files(packages: Callable[..., Path]) -> None:
    packages(
        under_test_equal="""
        made = []
        for name in ("first", "second"):
            exec(compile("def f(): return 0.5", name, "exec"), globals())
            made.append(f.__code__.co_filename)
        """
    )
    assert importlib.import_module("under_test_equal").made == ["first", "second"]
