"""Functions on numbers in instrumented programs: what plain ones print, and provenance."""

import contextlib
import io
import math
from textwrap import dedent

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rosslt_auto.instrument import calls, hook
from rosslt_auto.instrument.statistics_calls import call_statistics
from rosslt_auto.provenance import Source, provenance
from rosslt_auto.provenance.values import is_tracked, leaf, untracked


def tracked(value, name="x"):
    return leaf(Source("/node", name, type(value).__name__, named=True), value)


def inverted(value, target):
    return list(provenance(value).invert(target).changes.values())


PROGRAMS = {
    "math": """
        import math, math as m
        from math import sin as s, hypot, modf, comb
        xs = [0.5, 2, 1.25]
        k = 7
        print(s(0.5), m.cos(2), hypot(3, 4, 12), modf(-2.75), m.frexp(10.5), comb(k, 3))
        print(math.fsum([0.1] * 10), math.prod(xs), math.prod(xs, start=2))
        print(math.dist(xs, [1, 2, 3]))
        print(math.gcd(12, 18, 27), math.lcm(4, 6), math.isqrt(k), math.perm(k), math.perm(k, 2))
        print(math.factorial(k), math.ulp(0.5), math.nextafter(1.0, 2), math.ldexp(0.75, 3))
        print(math.floor(2.5), math.ceil(2.5), math.trunc(-2.5), math.log(8, 2), math.log(8.0))
        print(math.isclose(0.1, 0.1 + 1e-12), math.isnan(0.5), math.isfinite(0.5), math.pi * 2)
        print(list(map(math.sin, xs)), list(map(float, ['1', 2, 0.5])), list(map(max, xs, [1] * 3)))
        print(sorted(xs, key=math.cos), max(xs, key=math.sin), min([], default=0.5))
        print([*map(int, '1 2 3'.split())], *map(str, (1, 0.5)))
    """,
    "builtins": """
        x, n = 2.675, 17
        print(abs(-x), round(x, 2), round(n, -1), divmod(n, 5), divmod(x, 0.5))
        print(pow(n, 2), pow(x, 2))
        print(pow(n, 3, 5), pow(n, -1, 5), sum([x, 1], 2), sum([[1], [2]], []), bool(n), complex(x))
        print(int('42'), float(' 0.5 '), int('ff', 16), int('0b11', base=0), int(x), float(n))
        import operator, functools, itertools
        print(functools.reduce(operator.mul, [1, 2, 3.5]), list(itertools.accumulate([1, 2, 3])))
        print(operator.add(x, 1), operator.truediv(1, n), operator.index(n))
        print([0, 1][operator.lt(1, 2)])
        print((0.1).hex(), x.as_integer_ratio(), n.to_bytes(2, 'big'), f'{n:b}', bin(n), hex(n))
    """,
    "statistics": """
        import statistics
        from statistics import mean, stdev
        xs = [1.5, 2.5, 4, 8.25]
        print(mean(xs), mean([1, 2, 3, 4]), statistics.fmean(xs), statistics.median(xs), stdev(xs))
        print(statistics.variance(xs), statistics.pstdev(xs), statistics.pvariance([1, 2]))
        print(statistics.quantiles(xs), statistics.mode([1, 1, 2]), statistics.harmonic_mean(xs))
        print(mean(x for x in xs), statistics.fmean(xs, [1, 2, 3, 4]), statistics.variance(xs, 4.0))
        for wrong in ([], [1.0, 'a'], 5):
            try: mean(wrong)
            except Exception as error: print(type(error), error)
        from fractions import Fraction as F
        from decimal import Decimal as D
        print(mean([F(1, 2), 1]), mean([D('0.5'), 1]), F(1, 3) * 2, F(0.5), D(3) / 2, F(3, 4) + 0.5)
        print(round(D('2.675'), 2), D(0.1), F(1.5) ** 2, 2 ** F(1, 2))
    """,
    "times": """
        import datetime as dt, random, time
        random.seed(5)
        print(random.uniform(0.5, 2), random.gauss(0, 1.5), random.randint(1, 6))
        print(random.choice([1, 2]))
        print(random.sample(range(10), 3), random.random() * 2 < 2)
        print(dt.timedelta(seconds=0.5) * 3, dt.datetime(2024, 1, 2) + dt.timedelta(days=1.5))
        print(dt.timedelta(hours=2) / 4, dt.date(2024, 2, 29).replace(year=2023, day=1))
        time.sleep(0.001)
        print(time.gmtime(0)[0], time.strftime('%Y', time.gmtime(86400 * 2)))
    """,
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_same_output(name, tmp_path) -> None:
    source = dedent(PROGRAMS[name])
    path = tmp_path / "program.py"
    path.write_text(source)
    outputs = []
    for code in (
        compile(source, str(path), "exec", dont_inherit=True),
        hook.instrumented_code("program", str(path), source.encode(), cached=False),
    ):
        with contextlib.redirect_stdout(io.StringIO()) as out:
            exec(code, {"__name__": "program"})
        outputs.append(out.getvalue().splitlines())
    assert outputs[1] == outputs[0]


def test_programs_keep_provenance(instrumented) -> None:
    found = instrumented("""
        import math as m, statistics
        from math import modf, sin as s
        from statistics import stdev
        scale = 2.5
        number = '42'
        code = '2A'
        xs = [scale, 4.0]
        values = [
            s(scale), modf(scale)[0], m.fsum(xs), m.gcd(12, 18), m.ulp(scale),
            int(number), float(number), int(code, 16), int(code, base=16), max(scale, 1),
            statistics.mean(xs), stdev(xs), statistics.median(xs), sum(xs), round(scale, 1),
            *map(m.sin, xs), *map(float, [number]), abs(scale), divmod(scale, 2)[1], pow(scale, 2),
        ]
    """)
    assert [v for v in found["values"] if not is_tracked(v)] == []
    assert inverted(found["values"][5], 43) == ["43"]
    assert inverted(found["values"][7], 255) == ["FF"]


def test_statistics_is_known_by_its_functions() -> None:
    import statistics

    xs = [tracked(1.5), 2.5]
    assert is_tracked(call_statistics(statistics.mean, xs))
    assert not is_tracked(call_statistics(lambda items: 2.0, xs))
    assert list(call_statistics(reversed, xs))[1] is xs[0]


@pytest.mark.parametrize(
    ("text", "base", "target", "expected"),
    [
        ("42", (), 43, "43"),
        (" +12\n", (), -5, " -5\n"),
        ("007", (), 12, "012"),
        ("1_000", (), 1234567, "1_234_567"),
        ("0x2A", (0,), 43, "0x2B"),
        ("2A", (16,), 43, "2B"),
        ("0b0110", (2,), 1, "0b0001"),
        ("7z", (36,), 35, "z"),
        ("ff", (16,), 300, "12c"),
    ],
)
def test_an_int_is_written_as_it_was(text, base, target, expected) -> None:
    helper = calls.call_2 if base else calls.call_1
    value = helper(int, tracked(text), *base)
    assert untracked(value) == int(text, *base)
    assert inverted(value, target) == [expected]


@pytest.mark.parametrize(
    ("text", "target", "expected"),
    [("0.50", 0.75, "0.75"), ("5", 6.0, "6"), ("5", 6.5, "6.5"), ("1e3", 2e9, "2e9"),
     ("\t-.5", 0.25, "\t.25"), ("inf", 3.0, "3.0")],
)  # fmt: skip
def test_a_float_is_written_as_it_was(text, target, expected) -> None:
    value = calls.call_1(float, tracked(text))
    assert inverted(value, target) == [expected]


@given(text=st.text(max_size=8), base=st.integers(-1, 37))
def test_texts_are_read_as_plain_ones(text, base) -> None:
    for function, args in ((int, ()), (float, ()), (int, (base,))):
        results = []
        for x in (text, tracked(text)):
            try:
                helper = calls.call_2 if args else calls.call_1
                results.append(repr(untracked(helper(function, x, *args))))
            except ValueError as error:
                results.append(str(error))
        try:
            expected = repr(function(text, *args))
        except ValueError as error:
            expected = str(error)
        assert results == [expected, expected]


@given(x=st.floats(allow_nan=False, allow_infinity=False), y=st.floats(-1e9, 1e9))
def test_a_float_of_a_text_takes_any_value(x, y) -> None:
    value = calls.call_1(float, tracked(repr(x)))
    assert float(inverted(value, y)[0]) == y


def test_parts_of_a_float() -> None:
    fraction, whole = calls.call_1(math.modf, tracked(2.75))
    assert (inverted(fraction, 0.5), inverted(whole, 4.0)) == ([2.5], [4.75])
    mantissa, exponent = calls.call_1(math.frexp, tracked(2.75))
    assert (inverted(mantissa, 0.5), inverted(exponent, 4)) == ([2.0], [11.0])
