"""Remarks in comments and docstrings: what stays plain, what has a range, what is frozen."""

import ast
import logging
import textwrap
from pathlib import Path
from typing import Any

import pytest

from rosslt_auto.instrument import hook, remarks, weaving
from rosslt_auto.provenance.registry import location_of
from rosslt_auto.provenance.sources import SourceChangeRefused
from rosslt_auto.provenance.values import is_tracked, untracked


def rewritten(text: str) -> tuple[ast.Module, Any]:
    source = textwrap.dedent(text).encode()
    tree, _, found = weaving.rewritten_tree("sample", "sample.py", source)
    return tree, found


def tracked(text: str) -> list[Any]:
    """The values of the literals that are locations."""
    return list(rewritten(text)[1].values)


def warnings(text: str) -> list[str]:
    return list(rewritten(text)[1].warnings)


OFF = {
    "line": ("x = 0.5  # rosslt: off\ny = 1.5", [1.5]),
    "behind another comment": ("x = 0.5  # noqa: E501  # rosslt: off  # why\ny = 1.5", [1.5]),
    "two statements in a line": ("x = 0.5; y = 0.7  # rosslt: off\nz = 1.5", [1.5]),
    "the literals of its line": ("x = (0.5,\n  0.7,  # rosslt: off\n 1.5)", [0.5, 1.5]),
    "the whole statement": ("x = (0.5,\n  0.7,\n)  # rosslt: off\ny = 1.5", [1.5]),
    "first line without literals": ("x = dict(  # rosslt: off\n  a=0.5)\ny = 1.5", [1.5]),
    "long text": ("x = '''a\nb'''  # rosslt: off\ny = 1.5", [1.5]),
    "header only": ("for x in (0.5, 0.7):  # rosslt: off\n  y = 1.5", [1.5]),
    "function": ("def f(a=0.5):  # rosslt: off\n  return 0.7\ny = 1.5", [1.5]),
    "one line": ("def f(a=0.5): return 0.7  # rosslt: off\ny = 1.5", [1.5]),
    "long header": ("def f(\n  a=0.5,\n  b=0.7\n):  # rosslt: off\n  return 0.7\ny = 1.5", [1.5]),
    "argument": ("def f(\n  a=0.5,  # rosslt: off\n  b=0.7\n):\n  return 1.5", [0.7, 1.5]),
    "first in a function": ("def f():\n  '''D'''\n  # rosslt: off\n  return 0.7\ny = 1.5", [1.5]),
    "docstring": ("def f():\n  '''Doc.\n\n  rosslt: off\n  '''\n  return 0.7\ny = 1.5", [1.5]),
    "prose": ("def f():\n  '''Write rosslt: off for that.'''\n  return 0.7", [0.7]),
    "class": ("class A:  # rosslt: off\n  a = 0.5\n  def f(self): return 0.7\ny = 1.5", [1.5]),
    "decorated": ("@d(0.5)\n@e\ndef f():  # rosslt: off\n  return 0.7\ny = 1.5", [1.5]),
    "inner function": ("def f():\n def g():\n  # rosslt: off\n  return 0.7\n return 1.5", [1.5]),
    "module": ("#!/usr/bin/python\n# rosslt: off\nx = 0.5\ndef f(): return 0.7", []),
    "module docstring": ("'''Doc.\n\nrosslt: off\n'''\nx = 0.5", []),
    "on again": ("# rosslt: off\nx = 0.5\ndef f():  # rosslt: on\n  return 1.5", [1.5]),
    "inner off": ("# rosslt: off\nclass A:  # rosslt: on\n  x = 1.5\n  y = 2 # rosslt: off", [1.5]),
    "in a text": ("x = '# rosslt: off'; y = 1.5", ["# rosslt: off", 1.5]),
    "f-string": ("x = f'{y} metres'  # rosslt: off\ny = 1.5", [1.5]),
}  # fmt: skip


@pytest.mark.parametrize("text, left", OFF.values(), ids=OFF)
def test_off(text: str, left: list[Any]) -> None:
    assert tracked(text) == left
    assert warnings(text) == []


def test_nothing_in_a_function_that_is_off_is_rewritten() -> None:
    text = """
    import math
    def f(x, n):  # rosslt: off
        y = math.sin(float(x)) + 0.5 * sum([x])
        return f"{y:.3} metres", n in range(3)
    class A:
        # rosslt: off
        def __int__(self): return self.x + 1
    """
    assert ast.unparse(rewritten(text)[0]) == ast.unparse(ast.parse(textwrap.dedent(text)))


def test_names_of_others_stay() -> None:
    with_all = rewritten("def f():\n  g(0.5)\n  g(0.7)\n  g(0.9)")[1].infos
    some_off = rewritten("def f():\n  g(0.5)  # rosslt: off\n  g(0.7)\n  g(0.9)")[1].infos
    assert [one.parameter for one in some_off] == [one.parameter for one in with_all[1:]]


def limits(text: str) -> list[Any]:
    return [info.limits for info in rewritten(text)[1].infos]


def test_ranges() -> None:
    assert limits("x = 0.5  # rosslt: 0.0 to 2.0") == [(0.0, 2.0, None)]
    assert limits("x = 0.5  # rosslt: 0 to 2 step .5") == [(0.0, 2.0, 0.5)]
    assert limits("x = -3  # rosslt: -1_0 to +1e1  # metres") == [(-10, 10, None)]
    assert limits("x = f(0.5, 1.5)  # rosslt: 0 to 2\ny = 7.0") == [(0.0, 2.0, None)] * 2 + [None]
    assert limits("x = g('speed', 0.5)  # rosslt: 0 to 1")[-1] == (0.0, 1.0, None)
    kinds = [type(one) for one in limits("x = 0.5  # rosslt: 0 to 2 step 2.5e-1")[0]]
    assert kinds == [float, float, float]


def test_frozen() -> None:
    text = "x = 0.5  # rosslt: frozen\ndef f():  # rosslt: frozen\n  return 1.5\ny = 2.5"
    assert [(i.hint, i.frozen) for i in rewritten(text)[1].infos] == [
        ("x", True), ("f", True), ("y", False)]  # fmt: skip


BAD = {
    "x = 0.5  # rosslt: offf": "known are",
    "x = 0.5  # rosslt:": "known are",
    "x = 0.5  # rosslt: 2.0 to 0.0": "2.0 is not below 0.0",
    "x = 0.5  # rosslt: 0.0 to 2.0 step 0": "no step",
    "x = 0.5  # rosslt: 0.0 to 2.0 step 3": "no step",
    "x = 0.5  # rosslt: 0 to 1e999": "too large",
    "x = 0.5  # rosslt: 0 to 007": "no number",
    "x = 0.5  # rosslt: 0.0 to 2.0 step 0.3": "0.5 is not in it",
    "x = 'fast'  # rosslt: 0 to 1": "no number",
    "x = f(0.5, 7.0)  # rosslt: 0 to 1": "7.0 is not in it",
    "x = 5  # rosslt: 0.5 to 7": "range has to be one of ints",
    "pass  # rosslt: 0 to 1": "no number",
    "x = 0.5\n# rosslt: off\ny = 1.5": "alone in a line",
    "# rosslt: 0 to 1\nx = 0.5": "alone in a line",
}


@pytest.mark.parametrize("text, reason", BAD.items())
def test_bad_remarks_are_ignored_and_said(text: str, reason: str) -> None:
    (warning,) = warnings(text)
    line = next(n for n, one in enumerate(text.split("\n"), 1) if "rosslt:" in one)
    assert warning.startswith(f"sample.py:{line}: 'rosslt: ") and reason in warning
    assert tracked(text) == tracked(text.replace("rosslt:", ""))
    assert all(info.limits is None for info in rewritten(text)[1].infos)


def test_a_bad_remark_is_said_with_a_warm_cache_too(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.dont_write_bytecode", False)
    path, source = tmp_path / "warm.py", b"x = 0.5  # rosslt: slow\n"
    path.write_bytes(source)
    with caplog.at_level(logging.WARNING):
        for expected in (1, 1, 2):
            if expected == 2:
                monkeypatch.setattr(hook, "_warned", set())
                monkeypatch.setattr(weaving, "weave", lambda *_: pytest.fail("not from the cache"))
            exec(hook.instrumented_code("warm", str(path), source), {})
            assert caplog.text.count(f"{path}:1: 'rosslt: slow' is ignored") == expected


def test_files_without_remarks_are_not_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(remarks, "_Layout", None)
    monkeypatch.setattr(remarks.tokenize, "generate_tokens", None)
    assert tracked("x = 0.5  # rosslt") == [0.5]


@pytest.mark.parametrize("coding", ["latin-1", "utf-8"])
def test_any_encoding(coding: str) -> None:
    text = f"# coding: {coding}\r\nx = 'é'; y = 0.5  # rosslt: off\r\n\fz = 1.5  # é\r\n"
    _, _, found = weaving.rewritten_tree("sample", "sample.py", text.encode(coding))
    assert found.values == (1.5,)


def test_changes_of_limited_and_frozen_literals(instrumented) -> None:
    namespace = instrumented(
        """
        speed = 0.5  # rosslt: 0.0 to 2.0 step 0.1
        wheels = 4  # rosslt: 2 to 8
        mass = 1.5  # rosslt: frozen
        """
    )
    speed, wheels, mass = (location_of(f"rosslt.sample.{n}") for n in ("speed", "wheels", "mass"))
    assert [speed.check(v) for v in (0, 2, 0.30000000000000004)] == [0.0, 2.0, 0.30000000000000004]
    assert wheels.check(8) == 8
    assert mass.check(1.5) == 1.5  # nothing changes
    for location, value, reason in (
        (speed, 2.1, r"rosslt.sample.speed is limited to 0.0 to 2.0 step 0.1 at sample.py:2, it "),
        (speed, 0.55, "limited to"),
        (speed, -1, "cannot be -1.0"),
        (wheels, 9, "limited to 2 to 8"),
        (mass, 1.6, "rosslt.sample.mass is frozen at sample.py:4"),
    ):
        with pytest.raises(SourceChangeRefused, match=reason):
            location.check(value)
    assert all(is_tracked(namespace[name]) for name in ("speed", "wheels", "mass"))
    assert untracked(namespace["mass"]) == 1.5
