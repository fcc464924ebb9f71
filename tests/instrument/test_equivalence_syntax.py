"""Small programs with statements of which Python makes something else than of others, and with the
syntax of its later versions: the same output plain and instrumented.
"""

from collections.abc import Callable
from pathlib import Path
from textwrap import dedent
from types import CodeType

import pytest

from support.equivalence import WAYS, output, plain
from support.syntax import Since, cases

PROGRAMS = {
    "annotations": """
        import inspect, traceback
        from typing import Annotated, Literal, get_type_hints
        x: Annotated[float, 0.5] = 1.5
        y: Literal["text", 5]
        def f(a: Literal[2.5 if x else 3] = 1, *b: [0.5], c: "int" = 0.25, **d: {5: 1.5}) -> 5.5:
            e: Literal[6] = 7
            return a + e + c
        class A:
            k: Annotated[int, 1] = 2
            if x: l: Annotated[float, 3, lambda: 4.5] = 4
            for i in (1, 2): j: f = 5.5
            def m(self, n: (lambda: 0.5) = 1) -> "text": return self.k + n + self.j
        print(f(), f.__annotations__, inspect.signature(f), A().m(), A.m.__annotations__["return"])
        print(sorted(A.__annotations__), A.__annotations__["l"].__metadata__[1]())
        print(get_type_hints(A, include_extras=True)["k"], sorted(vars(A)))
        print(globals().get("__annotations__") or __annotate__(1))
        def g(a, b: 1 / (lambda: 0)() = 5): return a + b
        try: print(g(0.5)); g.__annotations__
        except ZeroDivisionError: traceback.print_exc()
    """,
    "annotations that stay texts": """
        from __future__ import annotations
        import typing
        x: missing[0.5] = 1.5
        def f(a: Literal["text", 5] = 2, *, b: lambda: 0.5 = 3.5) -> 1 + 2: return a + b
        class A:
            y: (x, 2.5) = 4
            def m(self) -> A: return self.y * 2
        print(f(), f.__annotations__, A.__annotations__, __annotations__, A().m())
        print(typing.get_type_hints(A.m, globals()))
    """,
    "ends": """
        import traceback
        def f(n):
            log = []
            for i in range(n):
                try:
                    try:
                        if i == 1: continue
                        if i == 3: break
                        if i == 4: return log, 0.5
                        log.append(i * 1.5)
                    finally:
                        log.append(f"{i} is done")
                        with open("/dev/null") as file: log.append(file.read() + "text")
                except ZeroDivisionError: pass
                else: log.append(2.5)
            try: return log, 3.5
            finally:
                if n > 5: log.append(1 / (n - 6))
        print(f(0), f(2), f(5), f(7))
        try: f(6)
        except ZeroDivisionError: traceback.print_exc()
        def g():
            try: yield 0.5
            finally: print("closed", 1.5)
        for v in g(): print(v); break
        print(any(v > 1.5 for v in (1, 2)), all(v for v in (0.5, 0)), set(v * 0.5 for v in (3,)))
        print(list(v + 1 for v in (0.5, 2)), tuple(v * 2.5 for v in (1, 2)))
        any, all, tuple = (lambda *v: ("mine", len(v))), sum, list
        print(any(v for v in (1, 2)), all(v for v in (0.5, 1)), tuple(v for v in (3, 4)))
    """,
}

PROGRAMS_SINCE: Since = {
    "parameters of types": (
        (3, 12),
        """
        import typing
        def f[T: (int, 5)](a: T = 0.5, *, b=1.5) -> T: return a + b
        class A[T, *U, **V](typing.Protocol):
            k = 2.5
            def m[W: (int, 0.5)](self, c: W = 3) -> W: return [self.k + c, f"{c} {self.k} {W}"]
        class B[T](A[T, 1, [2]]): k: T = 4.5
        type C = tuple[0.5, "text"]
        type D[T: 1.5] = list[T, 2]
        print(f(), B().m(), C.__name__, C.__value__, D[5], D.__value__, A.__type_params__)
        print(f.__type_params__[0].__constraints__, D.__type_params__[0].__bound__)
        print(f.__defaults__, f.__kwdefaults__, sorted(B.__annotations__))
        """,
    ),
    "defaults of types": (
        (3, 13),
        """
        def f[T = [0.5]](*, a: T = 1.5): return a + 2
        class A[T: int = 5, *U = (1, 2.5), **V = [3]]: k = 6.5
        type B[T = "text"] = list[T]
        print(f(), A.k, [t.__default__ for t in (*A.__type_params__, *B.__type_params__)])
        print(f.__type_params__[0].__default__, A, B.__value__)
        """,
    ),
    "templates": (
        (3, 14),
        """
        import traceback
        def f(x, n=8):
            t = t"a {x + 0.5!r:>{n}} b {n} {'abc'!s} {0.75!a:>8} {[i * 0.5 for i in (1, x)]:{n}}"
            u = t"{(lambda: 2.5)():5} {x is None} {n = }" + t"{g(t'{x!r:>{n}}', 5 if x else 1.5)}"
            return [*t.strings, t.interpolations, *u, *(t"" if x else t"text")]
        def g(*values): return values[1:]
        print(f(1), f(0.25))
        class A: z = 0.5; y = t"{z!r:{z}} {z + 1}".values; w = [t"{k!a}" for k in (1, 2)]
        print(A.y, A.w)
        print([*(t"{q:>{0.25}} {max(q, 2)!s}" for q in (5, 1.5))])
        def h(v):
            match v:
                case int(real=5) | A(): return t"{v!r}"
                case _ if v is not None: return t'{v is None!r:x}'
        print(h(5), h("a"), t"{h(0.5).values[0]}".values)
        def i(v): yield t"{(yield v):{(yield 1.5)}}"
        print(list(i(0.5)))
        try: t"{1} {2.5:{1 / (lambda: 0)()}}"
        except ZeroDivisionError: traceback.print_exc()
        """,
    ),
    "deferred annotations": (
        (3, 14),
        """
        import annotationlib, traceback
        def f(a: Later[0.5], b: missing(1.5) = 2.5) -> 3: return b * 2
        class A:
            x: Later[5] = 1.5
            y: missing[0.25]
            def m(self, z: Later[7] = 2): return self.x + z
        class Later:
            def __class_getitem__(cls, item): return ("item", item)
        print(f(1), A().m(), A.m.__annotations__, sorted(vars(A)))
        for one in (f, A):
            print(annotationlib.get_annotations(one, format=annotationlib.Format.STRING))
            found = annotationlib.get_annotations(one, format=annotationlib.Format.FORWARDREF)
            print([getattr(value, "__forward_arg__", value) for value in found.values()])
            try: one.__annotations__
            except NameError: traceback.print_exc()
        """,
    ),
    "several exceptions": (
        (3, 14),
        """
        def f(x):
            try: return 1.5 / x if x else [][5]
            except IndexError, ZeroDivisionError: return 0.5
            finally: print(2.5)
        print(f(0), f(2))
        try: raise ExceptionGroup("group", [ValueError(1.5), TypeError(2)])
        except* ValueError, TypeError: print(3.5)
        """,
    ),
}


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
@pytest.mark.parametrize("text", cases(PROGRAMS, PROGRAMS_SINCE))
def test_same_output(text: str, way: Callable[[str, Path], CodeType], tmp_path: Path) -> None:
    source = dedent(text).strip() + "\n"
    path = tmp_path / "program.py"
    expected = output(source, path, plain)
    assert expected
    assert output(source, path, way).splitlines() == expected.splitlines()
