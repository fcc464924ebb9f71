"""Operators with an int literal on the right: values, errors, order, and provenance."""

import math
import sys
import traceback
from decimal import Decimal
from fractions import Fraction
from textwrap import dedent

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosslt_auto.instrument import hook
from rosslt_auto.provenance.expressions import provenance
from rosslt_auto.provenance.values import is_tracked, untracked

SIGNS = ("+", "-", "*", "/", "//", "%", "**")
PROGRAM = """
N = 3
def plain_names(x):
    return x * N
class A:
    k = 4
    def __init__(self, x): self.x = x; self.__n = 2
    def scaled(self): return self.x / self.k
    def grow(self):
        self.x += 2
        return self.x
    def mangled(self): return self.x - self.__n
def item(values, at):
    values[at] *= 2
    return values[at]
def chain(x): return x * 2 + 1 - 3
""" + "\n".join(
    f"def f{i}_{n if n >= 0 else 'm'}(x): return x {sign} {n}\n"
    f"def g{i}_{n if n >= 0 else 'm'}(x):\n    x {sign}= {n}\n    return x"
    for i, sign in enumerate(SIGNS)
    for n in (0, 2, 7, -1)
)


@pytest.fixture(scope="module")
def programs(tmp_path_factory):
    """The namespaces of the program, plain and instrumented, from the same file."""
    path = tmp_path_factory.mktemp("operands") / "operands.py"
    path.write_text(PROGRAM)
    found = []
    for code in (
        compile(PROGRAM, str(path), "exec"),
        hook.instrumented_code("operands", str(path), PROGRAM.encode(), cached=False),
    ):
        namespace = {"__name__": "operands"}
        exec(code, namespace)
        found.append(namespace)
    return found


class Vector:
    def __init__(self, log):
        self.log = log

    def __mul__(self, other):
        self.log.append(("mul", other))
        return self

    def __iadd__(self, other):
        self.log.append(("iadd", other))
        return 0.5

    def __sub__(self, other):
        return NotImplemented

    def __repr__(self):
        return f"Vector({self.log})"


LEFT = [
    0.0, -0.0, 1.5, -2.5, math.inf, math.nan, 1e308, 5e-324, 0, 3, -7, 2**70, True, 1 + 2j,
    "ab", "%d", b"ab", [1, 2], (1,), None, Fraction(1, 3), Decimal("0.1"), {1: 2}, range(3), object,
]  # fmt: skip


def outcome(function, *args):
    """Result with its type, or the traceback's text as people see it."""
    try:
        value = untracked(function(*args))
    except Exception as error:
        trace = error.__traceback__.tb_next
        return "".join(traceback.format_exception(type(error), error, trace))
    return type(value), repr(value)


def copied(x):
    return x.copy() if type(x) is list else x


def test_values_errors_and_tracebacks(programs) -> None:
    plain, ours = programs
    names = [name for name in plain if name[:1] in "fg" and name[1:2].isdigit()]
    for name in names:
        for x in LEFT:
            assert outcome(ours[name], copied(x)) == outcome(plain[name], copied(x)), (name, x)
        assert outcome(ours[name], Vector([])) == outcome(plain[name], Vector([]))


@given(x=st.one_of(st.floats(), st.integers()), y=st.floats())
def test_numbers(programs, x, y) -> None:
    plain, ours = programs
    for name in [name for name in plain if name[:1] in "fg" and name[1:2].isdigit()]:
        expected = outcome(plain[name], x)
        assert outcome(ours[name], x) == expected
        tracked = ours["plain_names"](y)
        assert outcome(ours[name], tracked) == outcome(plain[name], untracked(tracked))
        if type(expected) is tuple:
            result = ours[name](x)
            assert is_tracked(result)
            again = provenance(result).evaluate({})
            assert repr(again) == repr(untracked(result))


def test_names_bound_to_int_literals(programs) -> None:
    _, ours = programs
    assert provenance(ours["plain_names"](0.5)).expression == "0.5 * N"
    one = ours["A"](1.5)
    assert provenance(one.scaled()).expression == "1.5 / k"
    assert provenance(one.mangled()).expression == "1.5 - n"
    assert provenance(one.grow()).expression == "1.5 + 2"
    assert provenance(ours["chain"](0.5)).expression == "0.5 * 2 + 1 - 3"
    assert provenance(ours["item"]([0.5], 0)).expression == "0.5 * 2"


def test_targets_are_evaluated_once_and_in_order(instrumented) -> None:
    source = """
        log = []
        class Noting:
            def __getattr__(self, name):
                log.append(('get', name))
                return Noting() if name == 'z' else 1.5
            def __setattr__(self, name, value): log.append(('set', name, value))
            def __getitem__(self, key): log.append(('item', key)); return 2.5
            def __setitem__(self, key, value): log.append(('put', key, value))
        def change(one, key):
            one.x += 1
            one[key] *= 2
            one[0] -= 3
            make().y //= 4
            one.z.w %= 5
            one[index()] **= 2
        def make(): log.append('make'); return Noting()
        def index(): log.append('index'); return 1
        change(Noting(), 'k')
        """
    plain = {}
    exec(dedent(source), plain)
    assert repr(instrumented(source)["log"]) == repr(plain["log"])


def test_unbound_names_fail_as_they_do(programs, tmp_path) -> None:
    source = (
        "def local():\n    x += 1\n"
        "def unknown():\n    return nothing * 2\n"
        "def missing(a):\n    a.x  -= 2\n"
        "def spread(a):\n    return (a.x\n        * 2)\n"
        "def twice(a):\n    return [1.5,  (a + 1) *   2]\n"
    )
    path = tmp_path / "unbound.py"
    path.write_text(source)
    plain, ours = {}, {}
    exec(compile(source, str(path), "exec"), plain)
    exec(hook.instrumented_code("unbound", str(path), source.encode(), cached=False), ours)
    for name in ("local", "unknown"):
        assert outcome(ours[name]) == outcome(plain[name])
    for name in ("missing", "spread", "twice"):
        assert outcome(ours[name], None) == outcome(plain[name], None)


@pytest.mark.parametrize("x", [2.5, 3, "a"])
def test_lines_are_told_as_without(x, tmp_path) -> None:
    source = (
        "def f(x):\n    y = (x\n         * 2)\n    x *= (\n        3)\n    return (\n    x\n) * 4\n"
    )
    path = tmp_path / "lines.py"
    path.write_text(source)

    def lines(code):
        namespace = {}
        exec(code, namespace)
        found = []

        def trace(frame, event, arg):
            if frame.f_code.co_filename != str(path):
                return None
            found.append((event, frame.f_lineno))
            return trace

        before = sys.gettrace()
        sys.settrace(trace)
        try:
            namespace["f"](x)
        finally:
            sys.settrace(before)
        return found

    ours = hook.instrumented_code("lines", str(path), source.encode(), cached=False)
    assert lines(ours) == lines(compile(source, str(path), "exec"))
