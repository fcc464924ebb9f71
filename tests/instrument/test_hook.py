"""The import hook, along the axes of pytest's tests of its own."""

import ast
import builtins
import copy
import importlib
import importlib.abc
import importlib.util
import inspect
import logging
import os
import runpy
import subprocess
import sys
import traceback
import warnings
import zipfile
from importlib.machinery import SourceFileLoader
from pathlib import Path

import pytest

from rosslt_auto.instrument import executed, hook, weaving
from rosslt_auto.instrument.selection import Selection
from rosslt_auto.provenance.values import is_tracked


def test_selected_modules_are_tracked(packages) -> None:
    packages(under_test_a="x = 0.5", other_module="x = 0.5")
    assert is_tracked(importlib.import_module("under_test_a").x)
    assert not is_tracked(importlib.import_module("other_module").x)
    del sys.modules["other_module"]


def test_namespaces_stay_clean(packages) -> None:
    source = "'doc'\nimport math\nx = math.sin(0.5)\nnames = sorted(globals())"
    packages(under_test_clean=source)
    module = importlib.import_module("under_test_clean")
    spec = importlib.util.spec_from_loader("plain", loader=None)
    plain = importlib.util.module_from_spec(spec)
    exec(source, vars(plain))
    expected = {"__file__", "__cached__", *vars(plain)}
    assert set(vars(module)) == expected
    assert set(module.names) | {"names"} == expected
    assert module.__doc__ == "doc"
    assert not [name for name in dir(module) if "@" in name]


@pytest.mark.xfail(
    sys.version_info < (3, 12), reason="3.11 tells tracers of unseen frames, too", strict=True
)
def test_a_tracer_sees_what_the_program_does(packages) -> None:
    seen = []

    def tracer(frame, event, arg):
        seen.append((frame.f_code.co_filename, event))
        return tracer

    folder = packages(under_test_traced="x = 0.5\n")
    before = sys.gettrace()
    sys.settrace(tracer)
    try:
        importlib.import_module("under_test_traced")
        during = sys.gettrace()
    finally:
        sys.settrace(before)
    assert during is tracer
    assert (str(folder / "under_test_traced.py"), "line") in seen
    assert not [place for place in seen if f"{os.sep}rosslt_auto{os.sep}" in place[0]]


@pytest.mark.xfail(
    sys.version_info < (3, 12), reason="3.11 tells tracers of unseen frames, too", strict=True
)
def test_a_tracer_sees_what_is_executed_and_not_how_it_is_rewritten(packages, monkeypatch) -> None:
    monkeypatch.setattr(executed, "_known", {})  # as if other tests had executed nothing
    seen = []

    def tracer(frame, event, arg):
        seen.append((event, frame.f_code.co_filename, frame.f_code.co_name))
        return tracer

    packages(under_test_executing="def f():\n    exec('x = 0.5')\n    return eval('1.5 * 2')\n")
    import under_test_executing

    before = sys.gettrace()
    sys.settrace(tracer)
    try:
        result = under_test_executing.f()
    finally:
        sys.settrace(before)
    assert type(result) is not float  # it was rewritten
    file = under_test_executing.__file__
    text = [(event, "<string>", "<module>") for event in ("call", "line", "return")]
    assert [place for place in seen if place[1] != __file__] == [
        ("call", file, "f"), ("line", file, "f"), *text,
        ("line", file, "f"), *text, ("return", file, "f"),
    ]  # fmt: skip


def test_the_rewriter_can_do_without_what_is_being_imported(tmp_path) -> None:
    """The whole standard library selected, and nothing in the cache."""
    code = (
        "import sys; from rosslt_auto.instrument import hook, selection\n"
        "for name in ('ast', 'tokenize', 'dataclasses', 're', 'copyreg', 'typing'):\n"
        "    sys.modules.pop(name, None)\n"
        "hook.install(selection.Selection(['*']))\n"
        "import {}; print(ast.parse('0.5').body[0].value.value) if '{}' == 'ast' else print(0.5)\n"
    )
    for name in ("ast", "tokenize"):
        done = subprocess.run(
            [sys.executable, "-c", code.format(name, name)],
            env={**os.environ, "PYTHONPYCACHEPREFIX": str(tmp_path / name)},
            capture_output=True, text=True,
        )  # fmt: skip
        assert (done.stdout, done.stderr) == ("0.5\n", "")


def test_namespace_of_builtins_can_be_copied(packages) -> None:
    packages(under_test_copied="x = 2.5\ndef f(): return f'{x} m'")
    module = importlib.import_module("under_test_copied")
    copied = copy.deepcopy(vars(builtins))
    assert copied.keys() == vars(builtins).keys()
    assert module.f() == "2.5 m"


def test_spec_and_loader_are_the_plain_ones(packages) -> None:
    folder = packages(under_test_spec="x = 1")
    module = importlib.import_module("under_test_spec")
    assert type(module.__spec__.loader) is SourceFileLoader
    assert module.__file__ == str(folder / "under_test_spec.py")
    assert module.__cached__ == importlib.util.cache_from_source(module.__file__)
    assert "rosslt" not in module.__cached__


def test_source_can_be_found(packages) -> None:
    packages(under_test_source="def f():\n    # comment\n    return 0.5\n")
    module = importlib.import_module("under_test_source")
    assert inspect.getsource(module.f) == "def f():\n    # comment\n    return 0.5\n"


def test_submodules_relative_and_circular_imports(packages) -> None:
    packages(
        under_test_pkg____init__="from . import a\ny = 1",
        under_test_pkg__a="from . import b\nx = 2",
        under_test_pkg__b="from . import a\nimport under_test_pkg\nz = 3\ndef f(): return a.x + z",
    )
    module = importlib.import_module("under_test_pkg.b")
    assert module.f() == 5 and is_tracked(module.f())


def test_namespace_packages(packages) -> None:
    packages(under_test_space__a="x = 1")
    assert is_tracked(importlib.import_module("under_test_space.a").x)


def test_reload_keeps_the_table(packages) -> None:
    packages(under_test_reload="def f(): return 0.5")
    module = importlib.import_module("under_test_reload")
    names = {name for name in vars(builtins) if name.startswith("@rosslt.under_test_reload.")}
    importlib.reload(module)
    again = {name for name in vars(builtins) if name.startswith("@rosslt.under_test_reload.")}
    assert len(names) == 1 and names == again
    assert module.f() == 0.5


def test_spec_from_file_location(packages) -> None:
    folder = packages(anything="x = 1")
    spec = importlib.util.spec_from_file_location("under_test name", folder / "anything.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert is_tracked(module.x)


def test_runpy(packages) -> None:
    packages(under_test_run="if __name__ == '__main__': x = 1")
    assert is_tracked(runpy.run_module("under_test_run", run_name="__main__")["x"])


def test_zip_archives(packages, monkeypatch) -> None:
    folder = packages()
    with zipfile.ZipFile(folder / "lib.zip", "w") as archive:
        archive.writestr("under_test_zipped.py", "x = 1")
    monkeypatch.syspath_prepend(str(folder / "lib.zip"))
    assert is_tracked(importlib.import_module("under_test_zipped").x)


def test_optimized_code_is_optimized(packages, monkeypatch) -> None:
    packages(under_test_assert="x = 1\nassert x == 2")
    with pytest.raises(AssertionError):
        importlib.import_module("under_test_assert")


def test_body_runs_once_and_errors_come_through(packages, monkeypatch) -> None:
    monkeypatch.setattr(sys, "bodies", 0, raising=False)
    packages(under_test_error="import sys\nsys.bodies += 1\nx = 1\nint('no number')")
    with pytest.raises(ValueError, match="no number") as caught:
        importlib.import_module("under_test_error")
    assert sys.bodies == 1
    files = {frame.filename for frame in traceback.extract_tb(caught.tb)}
    assert not [name for name in files if "rosslt_auto" in name]


def test_import_errors_come_through(packages) -> None:
    packages(under_test_missing="x = 1\nimport a_module_that_does_not_exist")
    with pytest.raises(ModuleNotFoundError) as caught:
        importlib.import_module("under_test_missing")
    assert caught.value.name == "a_module_that_does_not_exist"


@pytest.mark.parametrize(
    "source",
    [b"x = (1", b"def f(:\n pass", b"x = 1\n return 2", b"\0", b"\xff\xfe = 1", b"nonlocal x",
     b"f(**a, *b)", b"# coding: nothing\n", b"  x = 1\n y = 2", b"x: int = 1\nglobal x"],
)  # fmt: skip
def test_syntax_errors_are_the_plain_ones(packages, source: bytes) -> None:
    def error(name: str) -> str:
        (folder / f"{name}.py").write_bytes(source)
        importlib.invalidate_caches()
        with pytest.raises(SyntaxError) as caught:
            exec(f"import {name}", {})
        frames = traceback.extract_tb(caught.tb)
        assert frames[-1].filename == "<string>", frames
        text = "".join(traceback.format_exception_only(caught.value))
        where = [getattr(caught.value, name) for name in ("lineno", "offset", "end_offset")]
        return f"{text} {where}".replace(name, "name")

    folder = packages()
    assert error("under_test_syntax") == error("plain_syntax")


def test_a_module_that_cannot_be_rewritten_runs_plain(packages, monkeypatch, caplog) -> None:
    def fail(*args):
        raise RecursionError("too deep")

    monkeypatch.setattr(weaving, "rewrite", fail)
    packages(under_test_deep="x = 1", under_test_deeper="x = 2")
    with caplog.at_level(logging.WARNING):
        module = importlib.import_module("under_test_deep")
        importlib.reload(module)
        importlib.import_module("under_test_deeper")
    assert module.x == 1 and not is_tracked(module.x)
    assert len(caplog.records) == 2
    assert "under_test_deep.py" in caplog.text and "too deep" in caplog.text


def test_warnings_of_the_compiler_come_once_and_in_place(packages) -> None:
    packages(under_test_warn="x = 1\ny = x is 2\nz = '\\d'\n")
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        importlib.import_module("under_test_warn")
    found = [(os.path.basename(w.filename), w.lineno) for w in seen]
    assert sorted(found) == [("under_test_warn.py", 2), ("under_test_warn.py", 3)]


class _Doubling(ast.NodeTransformer):
    """Doubles what is returned, as a loader with transformations of its own."""

    def visit_Return(self, node):
        node.value = ast.BinOp(node.value, ast.Mult(), ast.Constant(2))
        return node


class _DoublingLoader(SourceFileLoader):
    def source_to_code(self, data, path, *, _optimize=-1):
        if not isinstance(data, ast.AST):
            data = ast.parse(data, path)
        tree = ast.fix_missing_locations(_Doubling().visit(data))
        return compile(tree, path, "exec", dont_inherit=True, optimize=_optimize)


def test_loaders_with_transformations_keep_them(packages) -> None:
    folder = packages(under_test_double="def f(): return 0.5")
    path = str(folder / "under_test_double.py")
    for _ in range(2):
        loader = _DoublingLoader("under_test_double", path)
        spec = importlib.util.spec_from_file_location("under_test_double", path, loader=loader)
        module = importlib.util.module_from_spec(spec)
        loader.exec_module(module)
        assert module.f() == 1.0 and is_tracked(module.f())
        (folder / "__pycache__").exists() and [p.unlink() for p in folder.glob("__pycache__/*")]
    assert is_tracked(importlib.import_module("under_test_double").f())


def test_two_hooks(packages) -> None:
    class Finder(importlib.abc.MetaPathFinder):
        def find_spec(self, name, path=None, target=None):
            if name != "under_test_found":
                return None
            return importlib.util.spec_from_file_location(name, folder / "elsewhere.py")

    folder = packages(elsewhere="x = 1")
    finder = Finder()
    sys.meta_path.insert(0, finder)
    try:
        assert is_tracked(importlib.import_module("under_test_found").x)
    finally:
        sys.meta_path.remove(finder)


def test_namespaces_of_metaclasses_are_not_asked(packages) -> None:
    source = """
    class Names(dict):
        def __missing__(self, name):
            if name.startswith("__"):
                raise KeyError(name)
            return name
    class Meta(type):
        @classmethod
        def __prepare__(cls, name, bases):
            return Names()
    class A(metaclass=Meta):
        x = 0.5
        y = undefined
        zs = [i * 2 for i in (1, 3)]
    """
    packages(under_test_meta=source)
    cls = importlib.import_module("under_test_meta").A
    assert (cls.x, cls.y, cls.zs) == (0.5, "undefined", [2, 6])
    assert not [name for name in vars(cls) if "@" in name]


def test_install_and_uninstall_leave_nothing(tmp_path: Path) -> None:
    loader = next(cls for cls in SourceFileLoader.__mro__ if "get_code" in vars(cls))
    plain, finders = vars(loader)["get_code"], (list(sys.meta_path), list(sys.path_hooks))
    for _ in range(2):
        hook.install(Selection(patterns=["under_test*"]))
        hook.install(Selection(patterns=["under_test*"]))
        assert vars(loader)["get_code"] is not plain
        hook.uninstall()
        hook.uninstall()
        assert vars(loader)["get_code"] is plain
    assert (list(sys.meta_path), list(sys.path_hooks)) == finders


def test_uninstalled_under_somebody_elses_patch(packages, monkeypatch) -> None:
    loader = next(cls for cls in SourceFileLoader.__mro__ if "get_code" in vars(cls))
    packages(under_test_patched="x = 1")
    ours = loader.get_code
    monkeypatch.setattr(loader, "get_code", lambda self, *args: ours(self, *args))
    hook.uninstall()
    assert not is_tracked(importlib.import_module("under_test_patched").x)
    monkeypatch.undo()
    hook.uninstall()


def test_threads_import_at_once(packages) -> None:
    import threading

    packages(**{f"under_test_thread{i}": f"x = {i}.5" for i in range(8)})
    threads = [
        threading.Thread(target=importlib.import_module, args=(f"under_test_thread{i}",))
        for i in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for i in range(8):
        value = sys.modules[f"under_test_thread{i}"].x
        assert is_tracked(value) and value == i + 0.5
