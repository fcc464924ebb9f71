"""Texts that leave the instrumented modules."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from rosslt_auto.instrument import foreign_calls
from rosslt_auto.instrument.code_objects import instrumented_code_object
from rosslt_auto.provenance import is_tracked

STRICT = """
import functools

def check(*texts, **named):
    for text in (*texts, *named.values()):
        if type(text) is not str and isinstance(text, str):
            raise TypeError(f"expected str, got {type(text).__name__}")
    return texts + tuple(named.values())

class Proj:
    def __init__(self, *texts, **named):
        self.texts = check(*texts, **named)
    def add_layer(self, name, gain=1.0):
        return check(name)[0], gain
    @classmethod
    def of(cls, name): return cls(name)
    def __call__(self, name): return check(name)[0]

bound = functools.partial(check, "first")
"""

PROGRAM = """
import strict_library
from strict_library import Proj, bound, check

ZONE = "utm"
class Holder:
    kind = "ellps"
    def __init__(self):
        self.mode = "fast"
    def all(self, name="a default"):
        zone = f"{ZONE}/3"
        proj = Proj(ZONE, name, proj="merc", zone=zone)
        return [
            proj.texts, Proj.of(self.mode).texts, proj.add_layer("grid", 2.5), proj("called"),
            strict_library.check(ZONE + "/4", self.kind), bound(name), *check("of", "these"),
        ]
holder = Holder()
result = holder.all()
own = (lambda text: text)("kept")
sorted_ones = sorted(["b", "a"], key=str.lower)
"""


@pytest.fixture
def library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    (tmp_path / "strict_library.py").write_text(STRICT)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield
    sys.modules.pop("strict_library", None)


def _from_source(source: str, instrumented: Callable[..., dict[str, Any]]) -> dict[str, Any]:
    return instrumented(source)


def _from_code(source: str, _: Any) -> dict[str, Any]:
    names: dict[str, Any] = {"__name__": "sample"}
    exec(instrumented_code_object(compile(source, "sample.py", "exec"), "sample"), names)
    return names


@pytest.mark.usefixtures("library")
@pytest.mark.parametrize("way", [_from_source, _from_code])
def test_texts_are_plain_in_modules_that_are_not_instrumented(
    instrumented: Callable[..., dict[str, Any]], way: Any
) -> None:
    plain: dict[str, Any] = {"__name__": "sample"}
    exec(PROGRAM, plain)
    names = way(PROGRAM, instrumented)
    assert names["result"] == plain["result"]
    assert type(names["result"][2][0]) is str
    assert is_tracked(names["result"][2][1]), "numbers are tracked there as well"
    assert is_tracked(names["ZONE"]) and is_tracked(names["holder"].mode)


def test_what_is_called_with_texts() -> None:
    class Interface:
        __module__ = "std_msgs.msg._string"

    class Foreign(type):
        def __getattribute__(cls, name: str) -> Any:
            raise AssertionError("nobody is asked")

    class Asked(metaclass=Foreign):
        __module__ = "elsewhere"

    foreign_calls.note("noted")
    noted = type("Noted", (), {"__module__": "noted"})
    for own in (Interface, noted, noted(), [].append, len, sys.intern, str.upper, functools.partial,
                functools.partial(Interface), {}.get, Path, Path("x").joinpath):  # fmt: skip
        assert foreign_calls.for_texts(own) == own
    nowhere = ModuleType("nowhere")
    exec("def f(): pass", vars(nowhere))
    nowhere.f.__module__ = ["not even a name"]
    assert foreign_calls.for_texts(nowhere.f) is nowhere.f
    library = ModuleType("library")
    exec("def f(): pass\nclass C:\n    def m(self): pass", vars(library))
    for foreign in (library.f, library.C, library.C().m, functools.partial(library.f), Asked):
        made = foreign_calls.for_texts(foreign)
        assert type(made) is functools.partial and made is not foreign
