"""Waiting for the import of a module."""

import importlib
import importlib.util
import sys
import traceback
import zipfile
from collections.abc import Callable, Iterator
from importlib.machinery import BuiltinImporter, SourceFileLoader
from pathlib import Path

import pytest

from rosslt_auto.provenance import imported
from rosslt_auto.provenance.imported import AfterImport, AfterImports


@pytest.fixture
def waited(monkeypatch, tmp_path: Path) -> Iterator[Callable[[str], list[str]]]:
    """Waits for a module and gives a list that tells how often it was imported."""
    monkeypatch.syspath_prepend(str(tmp_path))
    waiting = []

    def wait(name: str) -> list[str]:
        seen: list[str] = []
        waiting.append(AfterImport(name, lambda: seen.append(sys.modules[name].__name__)))
        return seen

    before = list(sys.meta_path)
    yield wait
    for one in waiting:
        one.cancel()
        sys.modules.pop(one.name, None)
    assert sys.meta_path == before


def test_told_once_and_nothing_left(waited, tmp_path: Path) -> None:
    (tmp_path / "awaited_a.py").write_text("x = 1")
    finders = list(sys.meta_path)
    seen = waited("awaited_a")
    module = importlib.import_module("awaited_a")
    importlib.reload(module)
    assert seen == ["awaited_a"] and sys.meta_path == finders
    assert type(module.__loader__) is SourceFileLoader is type(module.__spec__.loader)
    assert "exec_module" not in vars(module.__loader__)


def test_told_at_once_of_what_is_there(waited) -> None:
    seen: list[int] = []
    AfterImport("sys", lambda: seen.append(1))
    assert seen == [1]


def test_looking_for_a_module_is_not_importing_it(waited, tmp_path: Path) -> None:
    (tmp_path / "awaited_b.py").write_text("x = 1")
    seen = waited("awaited_b")
    assert type(importlib.util.find_spec("awaited_b").loader) is SourceFileLoader
    assert seen == []
    importlib.import_module("awaited_b")
    assert seen == ["awaited_b"]


def test_several_wait_for_one_module(waited, tmp_path: Path) -> None:
    (tmp_path / "awaited_c.py").write_text("x = 1")
    first, second = waited("awaited_c"), waited("awaited_c")
    importlib.import_module("awaited_c")
    assert first == second == ["awaited_c"]


def test_one_finder_for_all(waited) -> None:
    before = len(sys.meta_path)
    waited("awaited_g")
    waited("awaited_h")
    assert len(sys.meta_path) <= before + 1


def test_modules_of_a_kind(waited, tmp_path: Path) -> None:
    (tmp_path / "awaited_kind_a.py").write_text("x = 1")
    (tmp_path / "awaited_kind_b.py").write_text("x = 2")
    importlib.import_module("awaited_kind_a")
    seen: list[str] = []
    kind = AfterImports(
        lambda name: name.startswith("awaited_kind_"), lambda module: seen.append(module.__name__)
    )
    kind.install()
    kind.install()
    assert seen == ["awaited_kind_a"]
    importlib.import_module("awaited_kind_b")
    kind.uninstall()
    del sys.modules["awaited_kind_b"]
    importlib.import_module("awaited_kind_b")
    assert seen == ["awaited_kind_a", "awaited_kind_b"]
    del sys.modules["awaited_kind_a"], sys.modules["awaited_kind_b"]


def test_an_import_that_failed_is_tried_again(waited, tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "awaited_d.py").write_text("import sys\nx = 1 / sys.awaited")
    seen = waited("awaited_d")
    monkeypatch.setattr(sys, "awaited", 0, raising=False)
    with pytest.raises(ZeroDivisionError) as caught:
        importlib.import_module("awaited_d")
    assert not [f for f in traceback.extract_tb(caught.tb) if f.filename == imported.__file__]
    assert seen == []
    monkeypatch.setattr(sys, "awaited", 2)
    importlib.import_module("awaited_d")
    assert seen == ["awaited_d"]


def test_lazy_loader(waited, tmp_path: Path) -> None:
    (tmp_path / "awaited_e.py").write_text("x = 1")
    seen = waited("awaited_e")
    spec = importlib.util.find_spec("awaited_e")
    spec.loader = importlib.util.LazyLoader(spec.loader)
    module = importlib.util.module_from_spec(spec)
    sys.modules["awaited_e"] = module
    spec.loader.exec_module(module)
    assert seen == []
    assert module.x == 1 and seen == ["awaited_e"]


def test_archives_have_one_loader_for_all(waited, tmp_path: Path, monkeypatch) -> None:
    with zipfile.ZipFile(tmp_path / "lib.zip", "w") as archive:
        archive.writestr("awaited_f.py", "import awaited_beside")
        archive.writestr("awaited_beside.py", "")
    monkeypatch.syspath_prepend(str(tmp_path / "lib.zip"))
    seen = waited("awaited_f")
    assert importlib.util.find_spec("awaited_f") is not None
    importlib.import_module("awaited_beside")
    assert seen == []
    importlib.import_module("awaited_f")
    assert seen == ["awaited_f"]
    del sys.modules["awaited_beside"]


def test_built_in_modules(waited, monkeypatch) -> None:
    monkeypatch.delitem(sys.modules, "_symtable", raising=False)
    seen = waited("_symtable")
    module = importlib.import_module("_symtable")
    assert seen == ["_symtable"]
    assert module.__loader__ is BuiltinImporter is module.__spec__.loader
