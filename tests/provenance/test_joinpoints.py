"""Weaving: what is replaced, when, and what is there afterwards."""

import importlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosslt_auto.provenance.joinpoints import JoinPoints, around


class Base:
    def inherited(self) -> str:
        return "inherited"


@pytest.fixture
def points():
    points = JoinPoints()
    finders = list(sys.meta_path)
    yield points
    points.restore()
    assert sys.meta_path == finders


@pytest.fixture
def owner() -> Any:
    class Owner(Base):
        def plain(self) -> str:
            return "plain"

        def other(self) -> str:
            return "other"

    return Owner


def saying(word: str) -> Callable[[Any], Any]:
    """Makes functions that say a word before what the original says."""
    return lambda original: lambda *args: f"{word} {original(*args)}"


def loud(wrapped: Any, instance: Any, args: Any, kwargs: Any) -> str:
    return f"{type(instance).__name__}: {wrapped(*args, **kwargs).upper()}"


def test_replaced_and_restored(points: JoinPoints, owner: Any) -> None:
    before = dict(vars(owner))
    assert not points
    points.replace(owner, "plain", saying("ours"))
    assert points and owner().plain() == "ours plain"
    points.restore()
    assert not points and dict(vars(owner)) == before
    points.restore()
    assert dict(vars(owner)) == before


def test_replaced_once(points: JoinPoints, owner: Any) -> None:
    for _ in range(3):
        points.replace(owner, "plain", saying("ours"))
    assert owner().plain() == "ours plain"
    points.restore()
    points.replace(owner, "plain", saying("again"))
    assert owner().plain() == "again plain"


def test_what_is_not_there_is_not_replaced(points: JoinPoints, owner: Any) -> None:
    points.replace(owner, "missing", saying("ours"))
    points.replace(owner, "inherited", saying("ours"))
    assert not points and not hasattr(owner, "missing")
    assert owner().inherited() == "inherited" and "inherited" not in vars(owner)


def test_functions_of_modules(points: JoinPoints) -> None:
    import keyword

    plain = keyword.iskeyword
    points.replace(keyword, "iskeyword", saying("ours"))
    assert keyword.iskeyword("if") == "ours True"
    points.restore()
    assert keyword.iskeyword is plain


def test_advice(points: JoinPoints, owner: Any) -> None:
    points.advise(owner, "plain", loud)
    assert owner().plain() == "Owner: PLAIN" and owner.plain.__name__ == "plain"
    points.restore()
    assert owner().plain() == "plain"


@pytest.mark.parametrize("name", ["inherited", "missing"])
def test_no_method_to_advise(points: JoinPoints, owner: Any, name: str) -> None:
    with pytest.raises(AttributeError, match=f"Owner has no method {name}"):
        points.advise(owner, name, loud)
    assert not points


def test_restored_last_first(points: JoinPoints) -> None:
    restored = []

    class Noting(type):
        def __setattr__(cls, name: str, value: Any) -> None:
            restored.append(name)
            super().__setattr__(name, value)

    class Noted(metaclass=Noting):
        a = b = c = "plain"

    for name in "acb":
        points.replace(Noted, name, lambda original: "ours")
    restored.clear()
    points.restore()
    assert restored == ["b", "c", "a"] and (Noted.a, Noted.b, Noted.c) == ("plain",) * 3


def test_under_somebody_elses_it_stays_and_comes_in_once(points: JoinPoints, owner: Any) -> None:
    points.replace(owner, "plain", saying("ours"))
    points.replace(owner, "other", saying("ours"))
    ours = owner.plain
    owner.plain = theirs = saying("their")(ours)
    points.restore()
    assert not points and owner.plain is theirs and owner().other() == "other"
    points.replace(owner, "plain", saying("ours"))
    assert owner.plain is theirs
    owner.plain = ours
    points.restore()
    assert owner().plain() == "plain"


def test_woven_anew_where_somebody_else_has_restored_it(points: JoinPoints, owner: Any) -> None:
    plain = owner.plain
    points.replace(owner, "plain", saying("first"))
    owner.plain = plain
    points.restore()
    points.replace(owner, "plain", saying("second"))
    assert owner().plain() == "second plain"
    points.restore()
    assert owner.plain is plain


@pytest.fixture
def awaited(monkeypatch, tmp_path: Path):
    """The name of a module that can be imported, and has not been."""
    name = "join_points_awaited"
    (tmp_path / f"{name}.py").write_text(
        "def function(): return 'plain'\nclass Outer:\n    class Inner:\n"
        "        def method(self): return 'plain'\n"
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    yield name
    sys.modules.pop(name, None)


@pytest.mark.parametrize("early", [False, True])
def test_replaced_when_imported(points: JoinPoints, awaited: str, early: bool) -> None:
    if early:
        importlib.import_module(awaited)
    for path in ("function", "Outer.Inner.method", "missing", "Outer.missing.method", "Missing.m"):
        points.replace_when_imported(awaited, path, saying("ours"))
    assert points and (awaited in sys.modules) is early
    module = importlib.import_module(awaited)
    assert module.function() == module.Outer.Inner().method() == "ours plain"
    assert not hasattr(module, "missing") and not hasattr(module, "Missing")
    points.restore()
    assert module.function() == module.Outer.Inner().method() == "plain"


def test_called_when_imported(points: JoinPoints, awaited: str) -> None:
    seen: list[str] = []
    points.when_imported(awaited, lambda: seen.append(awaited))
    assert points and seen == []
    importlib.import_module(awaited)
    assert points and seen == [awaited]


def test_waiting_ends(points: JoinPoints, awaited: str) -> None:
    seen: list[str] = []
    points.when_imported(awaited, lambda: seen.append(awaited))
    points.replace_when_imported(awaited, "function", saying("ours"))
    points.restore()
    assert not points
    assert importlib.import_module(awaited).function() == "plain" and seen == []


def test_advice_for_what_is_imported_later(points: JoinPoints, awaited: str) -> None:
    points.replace_when_imported(awaited, "Outer.Inner.method", around(loud))
    module = importlib.import_module(awaited)
    assert module.Outer.Inner().method() == "Inner: PLAIN"
