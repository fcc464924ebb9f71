"""Texts in instrumented programs: the plain program's output, and provenance beside it."""

import asyncio
import contextlib
import io
from collections.abc import Callable
from textwrap import dedent
from typing import Any

import pytest

from rosslt_auto.instrument import hook
from rosslt_auto.provenance.expressions import provenance
from rosslt_auto.provenance.values import TrackedStr, is_tracked

PROGRAMS = {
    "operations": """
        a = 'abc'
        b = 'de'
        print(a + b, a * 2, 2 * a, a[1], a[-2:], a[::-1], len(a), a < b, a == 'abc', 'b' in a)
        print('-'.join([a, b]), '-'.join(c for c in a), '%s|%5s|%-5s|%%' % (a, b, a), '%r' % a)
        print('{} {0!r:>8}'.replace('{} ', '').format(a), '{x:>5}'.format(x=b), '{{}}'.format())
        print(a.upper(), a.title(), a.center(9, '*'), a.split('b'), a.partition('b'), a.find('c'))
        print(a.encode(), a.isalpha(), a.startswith('a'), a.zfill(6), sorted(a), list(a))
        print(repr(a), str(a), format(a, '>6'), ascii(a), hash(a) == hash('abc'), bool(a), a or b)
        print(a is a, type(a), type(a) is str, isinstance(a, str), a.__class__ is str, len(dir(a)))
        a += b
        print(a, a.count('d'), min(a, b), max([a, b]), a.join(''), {a: 1}[a], {'abcde': 2}[a])
        print(int('12') + float('1.5'), '%d' % 3.7, '%(k)s' % {'k': a}, '%s' % (None,), '%s' % [a])
    """,
    "f-strings": """
        import datetime
        name = 'probe'
        n = 4
        x = 0.125
        w = 9
        print(f'{name} {n:d} of 10')
        s = f'{name!r:>{w}}|{x:.2f}|{n:05d}|{n:x}|{x!s:<8}|{n=}|{x = :.1f}|{name + "!"}|{{}}'
        print(s, len(s))
        t = f'{f"{n} inner {x}"} outer {True} {None} {[n, x]} {datetime.date(2020, 1, 2):%d.%m.%y}'
        print(t)
        def f(k):
            return f'{k}<{f(k - 1) if k else ""}>'
        print(f(5))
        class Odd:
            def __init__(self): self.calls = []
            def __format__(self, spec): self.calls.append(spec); return 'odd' + spec
            def __str__(self): return 'str of odd'
        odd = Odd()
        u = f'at {odd:abc} {odd!s} {n}'
        print(u, odd.calls)
        v = f'a' 'b' f'{n}' 'c'
        print(v, f'{n}' == '4', {f'k{n}': 1})
        order = []
        def note(x): order.append(x); return x
        q = f'{note(1)} and {note(2):{note(3)}} and {note("4")!r}'
        print(q, order)
        def broken(k):
            try:
                return f'{n} {1 // k} x'
            except ZeroDivisionError as error:
                return f'{broken(k + 1)} after {error}'
        print(broken(0), broken(0))
        print([f'{i}/{n}' for i in range(3)], (lambda k: f'{k}%')(n), f'''{n}
        {x}''')
    """,
    "plumbing": """
        import collections, dataclasses, enum, json, os, pickle, copy, re, struct, operator, pathlib
        MODE = 'fast'
        @dataclasses.dataclass
        class P:
            name: str = 'n'
            kind: 'str' = dataclasses.field(default='k', metadata={'m': 'x'})
        print(P(), P('q').name, dataclasses.asdict(P()))
        N = collections.namedtuple('N', 'a b')
        print(N('x', 'y'), N._fields)
        E = enum.Enum('E', 'A B')
        class F(str, enum.Enum):
            X = 'x'
        print(list(E), F.X, F('x'), F.X.value)
        d = dict(a='1', b='2')
        print(d, json.dumps(d), json.loads(json.dumps([MODE])), pickle.loads(pickle.dumps(MODE)))
        print(copy.deepcopy([MODE]), re.sub('a', 'b', MODE), os.path.join('a', MODE), MODE in d)
        class A:
            pass
        A.x = 1
        NAME = 'x'
        setattr(A, NAME, 5)
        print(getattr(A, NAME), getattr(A, 'y', 'none'), operator.attrgetter(NAME)(A), vars(A)['x'])
        def g(**k): return k
        print(g(**{NAME: 1, 'z': 'w'}), struct.pack('<d', 0.5), pathlib.PurePath('a') / 'b' / MODE)
        match MODE:
            case 'slow': print('no')
            case str(s): print('yes', s)
        print(type('T', (), {NAME: 1}).x, eval('1 + 1'), globals()['MODE'], sorted(g(c='d')))
        print(' '.join(sorted({'b', 'a'})), str(b'x', 'ascii'), 'x'.encode('ascii'), '%s' % 'x')
        x: 'int' = 3
        print(globals().get("__annotations__"), __name__)
        print(str(3), str(), str(0.5), str(None), str([MODE]))
    """,
    "errors": """
        import traceback
        a = 'abc'
        n = 3
        def attempt(f):
            try:
                print(f())
            except Exception as error:
                traceback.print_exception(error)
        attempt(lambda: a + n)
        attempt(lambda: n + a)
        attempt(lambda: a['x'])
        attempt(lambda: a[7])
        attempt(lambda: '%d' % a)
        attempt(lambda: '%s %s' % a)
        attempt(lambda: '{} {}'.format(a))
        attempt(lambda: ', '.join([a, n]))
        attempt(lambda: ', '.join(n))
        attempt(lambda: f'{a:d} x')
        attempt(lambda: f'{n:q} x')
        attempt(lambda: f'{a} {1 / 0}')
        attempt(lambda: f'{undefined} x')
        attempt(lambda: int(a))
        attempt(lambda: float('x' + a))
        attempt(lambda: a.nosuch)
        attempt(lambda: a * 1.5)
        attempt(lambda: min(a, n))
        attempt(lambda: max(n, None))
        attempt(lambda: min(n))
        attempt(lambda: min())
        attempt(lambda: str(a, 'x'))
        attempt(lambda: {}[a])
        attempt(lambda: getattr(n, 'a' + a))
    """,
}


@pytest.mark.parametrize("program", PROGRAMS)
def test_the_same_output(program: str, tmp_path: Any) -> None:
    path = tmp_path / f"{program.replace('-', '_')}.py"
    source = dedent(PROGRAMS[program])
    path.write_text(source)
    plain = _output(compile(source, str(path), "exec"))
    code = hook.instrumented_code("__main__", str(path), source.encode(), cached=False)
    assert _output(code) == plain


def _output(code: Any) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
        exec(code, {"__name__": "__main__"})
    return out.getvalue()


def test_a_text_is_taken_apart(instrumented: Callable[..., dict[str, Any]]) -> None:
    names = instrumented("""
    label = 'battery'
    n = 3
    text = f'{label} {n:d} of 10'
    other = '%s: %d' % (label, n)
    third = label + '/' + str(n)
    """)
    for name, wanted, changes in (
        ("text", "battery 4 of 10", {"n": 4}),
        ("text", "volts 4 of 10", {"label": "volts", "n": 4}),
        ("other", "battery: 7", {"n": 7}),
        ("third", "battery/5", {"n": 5}),
    ):
        found = provenance(names[name])
        assert found is not None
        solution = found.invert(wanted)
        assert {s.hint: v for s, v in solution.changes.items()} == changes


def test_coroutines_do_not_mix(instrumented: Callable[..., dict[str, Any]]) -> None:
    names = instrumented("""
    import asyncio
    n = 3
    async def one(k):
        await asyncio.sleep(0)
        return k
    async def text(k):
        return f'{n} {await one(k)} x'
    """)

    async def several() -> list[str]:
        return await asyncio.gather(*(names["text"](k) for k in range(4)))

    assert asyncio.run(several()) == [f"3 {k} x" for k in range(4)]


def test_what_an_error_leaves_behind_is_bounded(
    instrumented: Callable[..., dict[str, Any]],
) -> None:
    names = instrumented("""
    n = 3
    def f(k):
        return f'{n} {1 // k} x'
    """)
    for _ in range(5000):
        with pytest.raises(ZeroDivisionError):
            names["f"](0)
    text = names["f"](1)
    assert text == "3 1 x" and type(text) is TrackedStr
    assert is_tracked(text)


def test_names_are_looked_at_twice_and_nothing_else(instrumented) -> None:
    found = instrumented("""
        def named(a, b): return f'{a!r}:{b:>5}'
        def said(a): return f'{a} metres'
        class Counting:
            reads = 0
            @property
            def x(self):
                self.reads += 1
                return self.reads
        one = Counting()
        read = f'{one.x} {one.x:d}'
        speed = 1.5
        many = [None, True, [speed]]
        texts = [named(chr(97), len('ab')), named(speed, 'b'), said(speed), said(many)]
    """)
    assert found["read"] == "1 2"
    assert found["texts"][:3] == ["'a':    2", "1.5:    b", "1.5 metres"]
    assert [is_tracked(text) for text in found["texts"]] == [False, True, True, True]
    speed = provenance(found["texts"][2]).invert("2.5 metres")
    assert list(speed.changes.values()) == [2.5]
    assert "speed" in provenance(found["texts"][1]).expression
