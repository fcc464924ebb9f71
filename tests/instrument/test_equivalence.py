"""Small programs that could notice: the same output plain and instrumented."""

from collections.abc import Callable
from pathlib import Path
from textwrap import dedent
from types import CodeType

import pytest

from support.equivalence import WAYS, output, plain

PROGRAMS = {
    "order": """
        log = []
        def f(x): log.append(x); return x
        def g(*a, **k): log.append((a, k)); return 0
        g(f(1), *[f(2)], k=f(3), **{'m': f(4)})
        a = [0] * 5
        def i(): log.append('i'); return 1
        a[i()] += f(2)
        import math
        def pick(): log.append('pick'); return math
        print(f(2.0) * f(3) + float(f(4)) + math.sin(f(0)) + pick().sin(f(0)))
        x = [f(n) for n in (3, 1, 2)]
        print(log, a, sum(f(n) for n in (1, 2)))
    """,
    "namespaces": """
        x = 0.5
        def f(a=1, *, b=2):
            c = 3
            return sorted(locals()), f.__defaults__, f.__kwdefaults__, f.__code__.co_varnames
        class A:
            y = 1
            names = sorted(locals())
            zs = [q * 2 for q in (1, 2)]
        print(f(), f(**{'a': 4}), sorted(globals()), A.names, sorted(vars(A)), dir())
        def g(**k): return k
        def h(p=1.5): return g(**locals())
        print(h())
    """,
    "constants": """
        x = 5; y = 2.5; z = -0.0
        print(x, y, z, repr(x), str(y), f'{y:.3f} {x:>5} {y!r} {x:05d}', '%d %5.2f %s' % (x, y, z))
        print('{} {:x}'.format(y, x), x == 5, hash(y) == hash(2.5), {5: 'a'}[x], [1, 2, 3][x - 3])
        print(isinstance(x, int), isinstance(y, float), type(x) is int, type(y) == float, type(x))
        print(x.bit_length(), y.is_integer(), y.as_integer_ratio(), x.real, (0.5).hex())
        print(sorted([3, 1.5, 2]), max(3, 1), 3 in {3}, (1, 2) < (1, 3), divmod(-7, 2), 7 // 2)
        print(-7 % 3)
        print(x if x else 0, not x, bool(z), x and y, 2 ** -1, 2 ** 100, 1 << 70, ~5, 5 ^ 1)
        print(round(2.675, 2), round(2.5), abs(-3), int(-2.7), float(3), complex(1, 2), 1 + 2j)
        print(sum([0.1] * 10), sum([0.1] * 10, 0.5), sum([], 5), min([1.5], default=2))
        print(list(range(3)), 'ab' * 3, [0] * 3, (0,) * 2, bytes(3), chr(65), x in range(9))
        print(int('12'), float('1e5'), int('ff', 16), 10 .__add__(1), (5).__class__, y.__class__)
        n = 3; n *= 'ab'; print(n)
    """,
    "strings of types": """
        x = 0.5
        print(type(x), type(x).__name__, type(1).__module__, repr(type(x)), x.__class__.__name__)
        print(x.__doc__ == float.__doc__, dir(x) == dir(0.5), dir(1) == dir(int()))
        import copy, pickle, json, struct, array, decimal, fractions, math
        print(pickle.loads(pickle.dumps([x, 1])), copy.copy(x), copy.deepcopy([x, 1]))
        print(json.dumps({'a': x, 'b': [1, 2.5]}), struct.pack('<di', x, 7))
        print(array.array('d', [x, 1]))
        print(decimal.Decimal(x), fractions.Fraction(x), math.gcd(4, 6), math.comb(5, 2))
        match x:
            case 0.5: print('half')
        match 1, 2.0:
            case [int(a), float(b)]: print(a, b)
    """,
    "errors": """
        import math
        def e(f):
            try: f()
            except Exception as error:
                import traceback
                traceback.print_exc()
                print(repr(error), error.__context__, error.__cause__)
        e(lambda: 1 / 0)
        e(lambda: math.sqrt(-1.0))
        e(lambda: [1, 2][5 + 0])
        e(lambda: {1: 2}[3 * 1.0])
        e(lambda: 1 + 'a')
        e(lambda: 'a' + 1)
        e(lambda: float('x'))
        e(lambda: int(1e400))
        e(lambda: math.sin('x'))
        e(lambda: math.sin())
        e(lambda: sum([1, 'x']))
        e(lambda: [] < 0.5)
        e(lambda: len(5))
        e(lambda: 5 .nothing)
        e(lambda: -'x')
        e(lambda: math.hypot(1.0,
                             'a',
                             2))
        e(lambda: 10 ** 400 * 1.0)
        e(lambda: 2.0 ** 5000)
    """,
    "classes": """
        import dataclasses, enum, typing, collections, functools
        @dataclasses.dataclass
        class P:
            x: float = 0.5
            y: int = dataclasses.field(default=2)
            z: list = dataclasses.field(default_factory=lambda: [1, 2])
        class E(enum.IntEnum):
            A = 1
            B = A + 1
        class F(enum.Flag):
            X = 1
            Y = 2
        class N(typing.NamedTuple):
            a: int = 1
            b: float = 2.5
        class S:
            __slots__ = ('a',)
            def __init__(self): self.a = 1.5
            def __float__(self): return self.a * 2
            def __index__(self): return int(self.a) + 1
            def __len__(self): return 3
            def __hash__(self): return 7
            def __bool__(self): return self.a > 2
        T = collections.namedtuple('T', 'a b', defaults=[1, 2])
        @functools.lru_cache(maxsize=32)
        def f(x: typing.Literal[1, 2] = 1) -> typing.Annotated[int, 5]: return x
        import warnings
        warnings.simplefilter('error')
        s = S()
        print(P(), dataclasses.asdict(P(1.0)), list(E), E(2), F(3), N(), N(3)._asdict(), T())
        print(float(s), [1, 2, 3][s], len(s), hash(s), bool(s), f(), f.cache_info())
        print(typing.get_type_hints(f), f.__annotations__, P.__annotations__)
    """,
    "statements": """
        import contextlib
        def gen(n=3):
            got = yield 0.5
            print(got)
            for i in range(n):
                if i == 1: continue
                yield i * 2
            else: print('else')
            return 5
        g = gen(); print(next(g), g.send(7), list(g))
        def sub(): return (yield from gen(1))
        print(list(sub()))
        @contextlib.contextmanager
        def cm(x=1): yield x
        with cm(2) as a, cm() as (b): print(a, b)
        try:
            try: raise ValueError(1, 2.5)
            finally: print('finally', 1)
        except ValueError as e: print(e.args)
        while (n := 3 - 1) and a: a -= 1
        print(n, a, [y for x in ((1, 2), (3,)) for y in x if y != 2], {k: 1 for k in 'ab'}, {1})
        x, *y = 1, 2, 3
        (p, q), r = (1, 2), 3
        a = b = 4
        a += 1; a <<= 2; b **= 2; b %= 7
        print(x, y, p, q, r, a, b, 1 if a else 2, (lambda v=3: v + 1)())
        d = {'a': 1, **{'b': 2}}; d['c'] = 3; d.setdefault('e', 4); del d['a']
        print(d, [*range(2), 5], f'{1 + 1=} {2.5!s:>6} {3:{5}}')
        assert a > 1, 2
        import asyncio
        async def c(t=0): await asyncio.sleep(0); return [i async for i in ag()] + [t]
        async def ag():
            yield 1
            yield 2.5
        print(asyncio.run(c()))
        global z
        z = 5
        exec('print(z, 1.5)')
        print(eval('0.5 + z'))
    """,
    "shadowed": """
        def float(x): return ('mine', x)
        class math:
            @staticmethod
            def sin(x, y=2): return ('sin', x, y)
        int = lambda *a, **k: (a, k)
        type = int
        print(float(1), math.sin(1), math.sin(x=3), int(), int(1), int(1, b=2), type(1))
        def f():
            import math
            return math.sin(0.0)
        print(f(), sum([1, 2]))
        del int
        print(int(3.7))
    """,
    "deep": """
        print(eval('+'.join(['1'] * 300)), ((((((((((1)))))))))))
        def f(n): return 1 if n == 0 else f(n - 1) + 1
        print(f(200))
        class A:
            xs = [[i * 2 for i in (1, 2)] for j in range(3)]
            ys = {k: v + 0.5 for k, v in enumerate((1, 2))}
            class B: z = [lambda: 1.5 for q in (1,)]
        print(A.xs, A.ys, A.B.z[0]())
    """,
    "comprehensions": """
        import sys
        x = 5
        ys = [x for x in range(3) if (lambda: x)() != 1]
        locals(); sys._getframe().f_locals
        class A:
            k = 1
            zs = [k * 2.0 for k in (1, 2)]
            locals(); sys._getframe().f_locals
            print(k, zs)
        def f(a):
            g = float(sum([float(b) for b in a], 0.5)) if a else sum([c for c in (1, 2)])
            try: return [g, *[h for h in (0.5, 1.5)], max(g, *[1 / i for i in (1, 0)])]
            except ZeroDivisionError as error: return error, sorted(locals()), list(locals())
        print(x, ys, f([1, 2]), f([]), sorted(globals()))
    """,
    "executed": """
        from __future__ import annotations
        import traceback
        x = 0.5
        exec('y = x + 1.5; z: undefined = 2')
        def f(a):
            b = 2
            exec('c = a + b; print(sorted(locals()))')
            print(eval(' a * 2.5 + b'), eval('x'), sorted(locals()), eval('b', {'b': 7}))
            exec('global w; w = 5')
            exec('d = 1', globals(), {})
            names = {'a': 3}
            exec('e = a + 1\\ndef g(): return e * 2.0', names)
            print(names['e'], names['g'](), sorted(names))
            return [eval('q + 1') for q in (1, 2)] if False else eval('len', {})([1])
        print(y, globals().get("__annotations__"), f(1.5), w, sorted(globals()))
        def fails(*args, how=exec):
            try: print(how(*args))
            except BaseException as error: traceback.print_exc(); print(repr(error))
        def fails_here(text, *more):
            try: exec(text)
            except BaseException: traceback.print_exc()
            try: eval(text)
            except BaseException: traceback.print_exc()
            try: exec(text, *more)
            except BaseException: traceback.print_exc()
        fails_here('1 +'); fails_here('1 / 0'); fails_here(5); fails_here('x = ', 5)
        fails_here('def f(): return 1 / 0\\nf()', {}, []); fails_here('a\\0b')
        fails_here('print(0.5)', {'__builtins__': {'print': print}})
        fails_here('nothing', {'__builtins__': {}}); fails_here(b'print(1.5)'); fails_here('')
        class Names(dict):
            def __missing__(self, name): print('asked for', name); return 4
        print(eval('k + 1.5', {}, Names()))
        try: exec('print(k + 2.5)', {'print': print}, Names())
        except TypeError as error: print(error)
        class Answers(dict):
            def __getitem__(self, name): print('asked', name); return dict.get(self, name, 0.25)
        answers = Answers(print=print)
        exec('k = 2.5; print(k, other + 1.5)', answers); print(sorted(answers))
        exec('k = 3.5; print(k, other + 1.5)', {}, answers); print(sorted(answers))
        code = compile('r = [0.5, 1.5]; print(r, x)', 'made.py', 'exec')
        exec(code); exec(code, dict(globals()))
        print(eval(compile('x + 2', 'made.py', 'eval')), exec.__name__)
        fails(); fails('1', 5, how=eval); fails('print(2)')
        eval, kept = (lambda *a: ('mine', a)), eval
        print(eval('1'), kept('1.5'))
        class A:
            k = 1
            exec('m = k + 0.5')
            n = kept('m * 2')
        print(A.m, A.n, sorted(vars(A)))
    """,
    "docstring": '''
        """The doc."""
        from __future__ import annotations
        def f(x: undefined = 1) -> 5:
            """doc of f"""
            return x
        class C:
            """doc of C"""
            k = 1
            def m(self):
                1
                2.5
        print(__doc__, f.__doc__, f.__annotations__, C.__doc__, C.m.__doc__, f())
    ''',
}


@pytest.mark.parametrize("way", WAYS.values(), ids=WAYS)
@pytest.mark.parametrize("name", PROGRAMS)
def test_same_output(name: str, way: Callable[[str, Path], CodeType], tmp_path: Path) -> None:
    source = dedent(PROGRAMS[name]).strip() + "\n"
    path = tmp_path / "program.py"
    expected = output(source, path, plain)
    assert expected
    assert output(source, path, way).splitlines() == expected.splitlines()
