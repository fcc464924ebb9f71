"""Code without source: what becomes of a code object, compared with what becomes of its source."""

import ast
import io
import itertools
import logging
import sys
from collections.abc import Callable
from pathlib import Path
from textwrap import dedent
from types import CodeType, FunctionType
from typing import Any

import pytest
from bytecode import Bytecode, Instr

from rosslt_auto.instrument import hook
from rosslt_auto.instrument.code_objects import (
    instrumented_code_object,
    instrumented_function_code,
    instrumented_or_same,
    nested,
)
from rosslt_auto.instrument.code_walk import rewrite_code
from rosslt_auto.instrument.naming import module_scope
from rosslt_auto.instrument.rewriter import Rewritten, rewrite
from rosslt_auto.provenance import provenance
from rosslt_auto.provenance.locations import LiteralInfo
from rosslt_auto.provenance.registry import location_of
from support.syntax import Since, cases

Place = tuple[str, int, int]
Locations = dict[Place, tuple[Any, LiteralInfo]]


def _by_place(rewritten: Rewritten) -> Locations:
    return {
        (info.parameter, info.line, info.column): (value, info)
        for value, info in zip(rewritten.values, rewritten.infos, strict=True)
    }


def from_source(source: str, name: str = "sample", path: str = "sample.py") -> Locations:
    return _by_place(rewrite(ast.parse(source), module_scope(name, path), "@table"))


def from_code(source: str, name: str = "sample", path: str = "sample.py") -> Locations:
    code = compile(source, path, "exec", dont_inherit=True)
    return _by_place(rewrite_code(code, module_scope(name, path), "@table")[1])


SAME = {
    "assignments": """
        a = 0.5
        b = c = -1.5
        d: float = 2.5
        e, f = 0.25, 1.25
        g, *h = 1, 2, x
        k.attribute = 1
        k["key"] = 2; k[0] = 3; k[1:2] = [4, 5, 6]
        l += 0.5; k.x -= 1; k[n(7)] *= 2
        m, n = 0.5, n(1)
        __special__ = 5
    """,
    "functions": """
        def f(a, *, b=1.5, **c):
            x = 0.5
            return x * 2
        def g(y=0.5, z=x):
            def inner(): return 1
            async def other():
                await f(3.5)
                yield 0.25
            return lambda q=x, r=0.25: q + 2
        class A(B, key=4):
            k = 1
            @property
            def value(self): return 5.5
            @value.setter
            @decorated(with_numbers=3)
            def value(self, v): self.v = v + 0.5
            def __init__(self):
                self.x = 1.5
                for i in range(3): self.y = i + 2.5
            def __float__(self): return self.x + 2
            __int__ = lambda self: 3
            class C: z = [1.0, x, 2.0]
        class E(Enum):
            A = 1
            def f(self): return 0.5
    """,
    "calls": """
        f(1, 2.5, *x, k=3, **y)
        a.b.c(0.5)(1)[2](3)
        r = range(3); s = round(x, 2); t = isinstance(x, int) or int("3", 16)
        self.publisher = self.create_publisher(String, "topic", 10)
        print("x", 5); logging.info("%s", 1.5)
        u = max(1, x); v = math.sin(x + 0.5); w = sum([1, x], 0.5)
        "%s" .format(5); ", ".join(["a", x]); x.get("name", 0.5)
        f(a if b else 0.5, c or 1.5, not 2)
        raise ValueError("text", 5)
    """,
    "control": """
        for i in (0.5, 1.5):
            if i and x or f(0.7): a = 1
            elif i > 5: b = 2
            else: continue
            return_ = 3.5
        else: c = 4
        while x < 0.5 < y:
            x = x + 0.1
            if x: break
        with open(3) as f, g(0.5), h(1) as (i, j): k = 2
        try: a = f(1.5)
        except (A, B) as error: b = 2.5
        finally: c = 3.5
        l = 0.5 if x else y or 1.5
        m = x and 2 or 3.5
        assert x > 1, f(2)
        if (n := 3.5) > 2: pass
        match f(1), x:
            case [1, 2.5]: a = 4
            case {"k": b}: c = 5
            case D(e=6) if e > 7: g = 8
        del x[5], x[f(6)]
        z = x in range(5), x in (1, 2), x is None, [1, x][0], x[1:2]
        async def f():
            async with a(1) as b: c = 2.5
            async for d in e(2): f = g(3)
            return [h async for h in i(4)]
        def g():
            while x:
                try:
                    if z: return x
                finally: y = 1.5
            yield 1.25
            got = yield from f(2)
            return [n, 0.5, m]
    """,
    "displays": """
        a = [0.1, 0.2, 0.3]
        b = [0.1, x, 0.3]
        c = {"k": 1, "l": x, 5: 2, **y, "m": 0.5}
        d = {1, 2.5, x}
        e = [v * 0.5 for v in f(2) if v > 1]
        f = {k: v + 2 for k, v in zip(x, (1.0, 2.0))}
        g = sum(w + 0.5 for w in y)
        h = [[0.0] * 3 for i in range(2)] + [x, *y, 5]
        i = (1.5, "two", (3, -4), x)
        j = [lambda: s + 1.5 for q in r]
        k = {1 + s for s in t}
        def many(): return [{"x": 0.5, "y": -0.5}, (1, "a")]
    """,
    "texts": """
        a = "text" + x
        b = f"{x:.2f} and {y!r} {z:{w}}"
        c = f"{x}" + f"{x}{'y'}"
        d = x + "%d" % y
        e = "a" if x else "b"
        print(f"{x} said")
        def f(): return f"{x + 0.5} of {g(10)}"
        i = f"{x=} {y = !s}"
    """,
    "annotations": """
        a: A[0.5] = 1.5
        b: Literal["text", 5]
        def f(c: A[2.5] = x, *d: B[3], e: "int" = 0.25, **g: C[4]) -> D[5.5]:
            h: A[6] = 7
            i: E[8.5]
            self.j: F[9] = 0.75
            return h
        class G(B):
            k: A[1] = 2.5
            if x: l: A[3] = 4.5
            def m(self, n: lambda: 0.5 = x, *, q: 5 = 1) -> "text": return 2
        if x: o: A[7] = 8
        for p in q: r: A[0.125] = 5
    """,
    "private names": """
        class A:
            __a = 0.5
            def f(self, __b=x, *, __c=2.5, d=lambda __e=x, *, __f=3: __f):
                self.__g = 4.5
                __h, i = 5, 6
                self.__j(7.5)
                k(__l=8, m=9)
                for __n in (1.5, 2): self.__o[__p(0.25)] = [__q + 1 for __q in (x, 3)]
                return lambda: self.__r + 10
            class __B:
                def __f(self): self.__s = 0.75
        class _C__D: __t = 5
        def _E(): __u = 6; _E__v = __w(7)
    """,
    "functions with states": """
        def f(a, b=x, *, c=lambda *, d=0.5: d):
            with e(a): g = any(h > 0.5 for h in (1.5, a))
            i = all([j for j in (2, a)]), tuple(k + 1 for k in a), list(l for l in (3, a))
            return lambda m=a, *, n=0.25: m + n
        with o(1.5): pass
        with p, q(r=2.5) as s.t, u(3) as v["w"]: y = not a == 0.5
    """,
}

SAME_SINCE: Since = {
    "parameters of types": (
        (3, 12),
        """
        def f[T](a: T = x, *, b=1.5) -> T: return a + 2.5
        class A[T, *U, **V](B[U], c=3):
            d = 4.5
            def e[W: (int, G[5])](self, *, h: W = 6) -> W: return 7
        type I = J[0.5]
        type K[T: L[1.5]] = M[T, 2]
        class N[T]: o = 3.5
        """,
    ),
    "defaults of types": (
        (3, 13),
        """
        def f[T = A[0.5]](*, a: T = 1.5): return a + 2
        class B[T: C[2] = D[3], *U = *E[4], **V = [F[5]]]: g = 6
        type H[T = I[7]] = T
        """,
    ),
    "templates": (
        (3, 14),
        """
        a = t"{x} and {0.5} {y + 1.5!r:>{z}} {f(2)=} {'text'!s:x}"
        def g(n): return h(t"{n * 2.5!a}", t"{[i * 0.5 for i in (1, n)]:{n + 3}}{t'{4}'}")
        b = t"" + t"text", t"{c if x else 5}"
        """,
    ),
    "several exceptions": (
        (3, 14),
        """
        try: a = f(0.5)
        except A, B: b = 1.5
        except C, D.e: c = 2.5
        finally: d = 3.5
        """,
    ),
}


@pytest.mark.parametrize("text", cases(SAME, SAME_SINCE))
def test_same_locations(text: str) -> None:
    source = dedent(text).strip() + "\n"
    expected = from_source(source)
    found = from_code(source)
    assert found.keys() == expected.keys()
    for place, (value, info) in expected.items():
        assert found[place] == (value, info)
        assert type(found[place][0]) is type(value)


KNOWN = {
    "computed by the compiler: one location": "x = 2 * 0.3\n",
    "defaults in one constant: no places": "def f(a=1, b=2.5): pass\n",
    "on several lines, in one constant: no places": "x = [1.0,\n     2.0,\n     3.0]\n",
    "written otherwise than by Python, in one constant: no places": "x = [1.00, 2.0, 3.0]\n",
    "a template with a tuple is compiled as an f-string": "x = 'at %s, %s' % (y, z)\n",
    "nested targets: named by their own, not by the first": "(x, y), z = (1, 2), w\n",
    "jumps inside of an f-string": "h = f'{a if b else c} left'\n",
    "a constant result behind finally": "def f():\n  try: return 0.5\n  finally: x()\n",
    "truth values": "message.data = True\n",
    "an f-string without values is a text": "x = f'text'\n",
}

if (3, 12) <= sys.version_info < (3, 13):
    KNOWN["a constant result of a lambda expression"] = "f = lambda: 1.5\n"


@pytest.mark.parametrize(
    "source",
    [
        pytest.param(source, id=reason, marks=pytest.mark.xfail(strict=True, reason=reason))
        for reason, source in KNOWN.items()
    ],
)
def test_known_difference(source: str) -> None:
    assert from_code(source).keys() == from_source(source).keys()


def test_what_is_there_instead() -> None:
    places = {
        "x = 2 * 0.3\n": {("rosslt.sample.x", 1, 4): 0.6},
        "def f(a=1, b=2.5): pass\n": {
            ("rosslt.sample.f.a", 1, 0): 1,
            ("rosslt.sample.f.b", 1, 0): 2.5,
        },
        "x = [1.00, 2.0, 3.0]\n": {
            ("rosslt.sample.x", 1, 4): 1.0,
            ("rosslt.sample.x_2", 1, 4): 2.0,
            ("rosslt.sample.x_3", 1, 4): 3.0,
        },
        "x = '=' * 78\n": {},
    }
    for source, expected in places.items():
        assert {place: value for place, (value, _) in from_code(source).items()} == expected


class _Unknowable(ast.NodeVisitor):
    """The lines of a module on which a code object may show less than the source."""

    def __init__(self, source: str) -> None:
        self.lines: set[int] = set()
        self.visit(ast.parse(source))

    def _all(self, node: Any) -> None:
        self.lines.update(range(node.lineno, node.end_lineno + 1))

    def visit_FunctionDef(self, node: Any) -> None:
        defaults = [one for one in node.args.defaults if isinstance(one, ast.Constant)]
        for default in defaults:
            self._all(default)
            self.lines.update(range(node.lineno, node.body[0].lineno))
        self.generic_visit(node)

    visit_AsyncFunctionDef = visit_FunctionDef

    def visit_Lambda(self, node: Any) -> None:
        self._all(node)
        self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        parts = (node.left, node.right)
        template = isinstance(node.op, ast.Mod) and isinstance(node.right, ast.Tuple)
        if template or all(self._is_constant(part) for part in parts):
            self._all(node)
        self.generic_visit(node)

    def _is_constant(self, node: ast.expr) -> bool:
        if isinstance(node, ast.UnaryOp):
            return self._is_constant(node.operand)
        if isinstance(node, ast.BinOp):
            return self._is_constant(node.left) and self._is_constant(node.right)
        return isinstance(node, ast.Constant)

    def _display(self, node: Any) -> None:
        if any(self._is_constant(one) or isinstance(one, ast.Tuple) for one in node.elts):
            self._all(node)
        self.generic_visit(node)

    visit_List = visit_Tuple = visit_Set = _display

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        if not any(isinstance(part, ast.FormattedValue) for part in node.values):
            self._all(node)
        self.generic_visit(node)


MODULES = ["statistics", "fractions", "heapq", "json.encoder", "_pydecimal", "colorsys"]


@pytest.mark.parametrize("module", MODULES)
def test_same_locations_in_the_standard_library(module: str) -> None:
    path = Path(ast.__file__).parent.joinpath(*module.split(".")).with_suffix(".py")
    source = path.read_text()
    unknowable = _Unknowable(source).lines

    def known(locations: Locations) -> set[tuple[Any, ...]]:
        # Without the numbers at the end, which count the literals on the other lines too.
        return {
            (name.rstrip("0123456789").rstrip("_"), line, column, repr(value))
            for (name, line, column), (value, _) in locations.items()
            if line not in unknowable and type(value) is not bool
        }

    expected = known(from_source(source, module, str(path)))
    assert expected
    assert known(from_code(source, module, str(path))) == expected


@pytest.fixture
def executed(tmp_path: Path) -> Callable[..., dict[str, Any]]:
    """Executes a source text whose code object is instrumented, and gives its namespace."""

    def execute(source: str, module: str = "sample") -> dict[str, Any]:
        code = compile(dedent(source), str(tmp_path / f"{module}.py"), "exec", dont_inherit=True)
        namespace = {"__name__": module}
        exec(instrumented_code_object(code, module), namespace)
        return namespace

    return execute


def test_literals_are_live(executed: Callable[..., dict[str, Any]]) -> None:
    namespace = executed(
        """
        import math
        def f(x):
            for i in (0.5, 1.5):
                x = math.sin(x) + i
            return [x * 2, 0.25, -1.0], f"{x} m"
        """,
        "live",
    )
    values, text = namespace["f"](0.0)
    provenance_of = provenance(values[0])
    assert provenance_of is not None
    assert {source.parameter for source in provenance_of.sources} == {
        "rosslt.live.f.i", "rosslt.live.f.i_2", "rosslt.live.f.f",
    }  # fmt: skip
    assert str(text) == f"{values[0] / 2} m"
    location_of("rosslt.live.f.i_2").change(10.5)
    assert namespace["f"](0.0)[0][0] == 2 * (sys.modules["math"].sin(0.5) + 10.5)
    location_of("rosslt.live.f.f_2").change(0.125)
    assert namespace["f"](0.0)[0][1] == 0.125


def test_int_literals_beside_plain_floats(executed: Callable[..., dict[str, Any]]) -> None:
    namespace = executed(
        """
        def f(x):
            y = x * 2
            y += 1
            return y
        """,
        "operators",
    )
    value = namespace["f"](0.25)
    found = provenance(value)
    assert value == 1.5
    assert found is not None
    assert [source.parameter for source in found.sources] == [
        "rosslt.operators.f.y", "rosslt.operators.f.y_2",
    ]  # fmt: skip


def test_copies_of_a_literal_are_one_location() -> None:
    source = dedent(
        """
        def f(x):
            try:
                if x: return 1.5
                g(x)
            finally:
                h(0.5)
        """
    )
    code = compile(source, "copies.py", "exec")
    loads = [
        instr
        for one in nested(code)
        for instr in Bytecode.from_code(one)
        if isinstance(instr, Instr) and instr.require_arg() and instr.arg == 0.5
    ]
    assert len(loads) > 1
    assert [value for value, _ in from_code(source).values()] == [1.5, 0.5]


def _lines(code: CodeType) -> list[int | None]:
    """The lines that a tracer sees, in the order of the code."""
    return [line for line, _ in itertools.groupby(line for _, _, line in code.co_lines())]


def _functions(code: CodeType) -> dict[str, CodeType]:
    return {f"{one.co_qualname}:{one.co_firstlineno}": one for one in nested(code)}


@pytest.mark.parametrize("module", ["statistics", "_pydecimal", "textwrap", "asyncio.taskgroups"])
def test_everything_else_is_kept(module: str) -> None:
    path = Path(ast.__file__).parent.joinpath(*module.split(".")).with_suffix(".py")
    code = compile(path.read_text(), str(path), "exec", dont_inherit=True)
    made = rewrite_code(code, module_scope(module, str(path)), "@table")[0]
    assert made is not code
    plain, ours = _functions(code), _functions(made)
    assert ours.keys() == plain.keys()
    for name, one in plain.items():
        other = ours[name]
        for attribute in (
            "co_argcount", "co_posonlyargcount", "co_kwonlyargcount", "co_flags", "co_varnames",
            "co_freevars", "co_cellvars", "co_filename", "co_name", "co_firstlineno",
        ):  # fmt: skip
            assert getattr(other, attribute) == getattr(one, attribute), (name, attribute)
        assert set(other.co_positions()) == set(one.co_positions()), name
        assert _lines(other) == _lines(one)
        assert other.co_stacksize >= one.co_stacksize
        if one.co_flags & 0x3 and one.co_consts and type(one.co_consts[0]) is str:
            assert other.co_consts[0] == one.co_consts[0]  # the docstring


@pytest.mark.parametrize("module", ["argparse", "keyword", "statistics", "tokenize"])
def test_stack_is_large_enough(module: str) -> None:
    path = Path(sys.modules["os"].__file__ or "").with_name(f"{module}.py")
    plain = compile(path.read_bytes(), str(path), "exec", dont_inherit=True)
    for code in nested(instrumented_code_object(plain, module)):
        assert code.co_stacksize >= Bytecode.from_code(code).compute_stacksize(), code


@pytest.mark.parametrize(
    "source",
    [
        "x = (io\n  .StringIO('a').read(\n    max(\n      1, 2)\n  ))\n",
        "import math\nx = print(\n  math\n   .sin(\n    0.5\n   ))\n",
    ],
)
def test_lines_are_executed_in_the_same_order(source: str) -> None:
    plain = compile(source, "lines.py", "exec", dont_inherit=True)

    def lines_of(code: CodeType) -> list[int]:
        lines: list[int] = []

        def tracer(frame: Any, event: str, _: Any) -> Any:
            if event == "line" and frame.f_code.co_filename == "lines.py":
                lines.append(frame.f_lineno)
            return tracer

        outer = sys.gettrace()
        sys.settrace(tracer)
        try:
            exec(code, {"io": io})
        finally:
            sys.settrace(outer)
        return lines

    assert lines_of(instrumented_code_object(plain, "lines")) == lines_of(plain) != []


def test_untouched_code_is_the_same_object() -> None:
    code = compile("def f(x): return x[0]\nclass A: pass\ny = 1.5\n", "some.py", "exec")
    made = rewrite_code(code, module_scope("some", "some.py"), "@table")[0]
    assert made is not code
    inner = {one for one in nested(code) if one is not code}
    assert {one for one in nested(made) if one is not made} == inner
    assert {id(one) for one in nested(made) if one is not made} == {id(one) for one in inner}


def test_instrumented_code_is_left_alone(tmp_path: Path) -> None:
    path = str(tmp_path / "twice.py")
    code = hook.instrumented_code("twice", path, b"x = 0.5\n", cached=False)
    assert instrumented_code_object(code, "twice") is code


def _factory(gain: float) -> Callable[[float], Any]:
    namespace: dict[str, Any] = {}
    text = dedent(
        """
        def make(gain):
            def scaled(x, offset=0.25):
                def twice(y, times=2.0): return y * times * gain
                return twice(x) + 1.5
            return scaled
        """
    )
    exec(compile(text, "<gone>", "exec"), namespace)
    return namespace["make"](gain)


def test_function_whose_source_is_gone() -> None:
    function = _factory(3.0)
    plain = _factory(3.0)
    assert isinstance(function, FunctionType)
    made = instrumented_function_code(function.__code__, "gone")
    assert made.co_freevars == function.__code__.co_freevars
    function.__code__ = made
    value = function(1.0)
    assert value == plain(1.0) == 7.5
    found = provenance(value)
    assert found is not None
    assert [source.parameter for source in found.sources] == [
        "rosslt.gone.make.scaled.twice.times",
        "rosslt.gone.make.scaled.scaled",
    ]
    location_of("rosslt.gone.make.scaled.scaled").change(2.5)
    assert function(1.0) == 8.5


def test_code_that_is_not_understood_stays_plain(caplog: pytest.LogCaptureFixture) -> None:
    # Two ways to one place that leave two and three values, as no compiler would write it.
    source = "x = y if z else 0.5\na = b\nc = d\ne = f\ng = h\n"
    code = Bytecode.from_code(compile(source, "strange.py", "exec"))
    at = next(i for i, one in enumerate(code) if isinstance(one, Instr) and one.arg == "y")
    code.insert(at, Instr("LOAD_CONST", None))
    broken = code.to_code(stacksize=9, compute_exception_stack_depths=False)
    with caplog.at_level(logging.WARNING):
        assert instrumented_or_same(broken, "strange") is broken
        assert instrumented_or_same(broken, "strange") is broken
    assert len(caplog.records) == 1
    assert "runs without provenance" in caplog.text
