"""Random small programs: plain, instrumented from source, and instrumented as code objects."""

from typing import Any

from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from rosslt_auto.instrument import hook
from rosslt_auto.instrument.code_objects import instrumented_code_object
from rosslt_auto.provenance import provenance

_number = st.sampled_from(["0.5", "-1.5", "2", "3.0", "x", "y", "7"])
_operator = st.sampled_from(["+", "-", "*"])


def _compound(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    return st.one_of(
        # Parts that vary on the left: what is constant as a whole is computed by the compiler.
        st.builds("(x {} {})".format, _operator, inner),
        st.builds("({} if x < {} else {})".format, inner, inner, inner),
        st.builds("(y and {} or {})".format, inner, inner),
        st.builds("max(y, {})".format, inner),
        st.builds("float({})".format, inner),
        st.builds("math.sin({})".format, inner),
        st.builds("sum([q * {} for q in (x, y)], {})".format, inner, inner),
        st.builds("(lambda p, r=y: p - r + {})({})".format, inner, inner),
        st.builds("[x, y, {}][len(f'{{x}} {{y:.2f}}') % 3]".format, inner),
        st.builds("len(f'{{x.conjugate()}} and {{str({}).strip()!r:>9}}')".format, _number),
        st.builds("len(f'{{[q * {} for q in (x, y)]}} of {{y}}')".format, _number),
        st.builds(
            "len(f'{{(lambda p={}: p).__name__}} of {{(z := {})}}')".format, _number, _number
        ),
        st.builds("len(str([q + {} for q in (x, y)][0]).strip())".format, inner),
        st.builds("d.setdefault('k', {})".format, inner),
        st.builds("(z := {})".format, inner),
        st.builds("call(*[{}], k={})".format, inner, inner),
        st.builds("int({} // 3)".format, inner),
    )


_expression = st.recursive(_number, _compound, max_leaves=6)


def _nested(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    def indent(text: str) -> str:
        return "\n".join(f"    {line}" for line in text.split("\n"))

    block = inner.map(indent)
    return st.one_of(
        st.builds("{}\n{}".format, inner, inner),
        st.builds("if x > {}:\n{}\nelse:\n{}".format, _expression, block, block),
        st.builds("for n in range(2):\n{}\n    if x: continue".format, block),
        st.builds("try:\n{}\n    x /= 0\nexcept ZeroDivisionError:\n{}".format, block, block),
        st.builds("try:\n{}\nfinally:\n{}".format, block, block),
        st.builds("with here():\n{}".format, block),
    )


_statement = st.one_of(
    st.builds("x = {}".format, _expression),
    st.builds("x, y = {}, {}".format, _expression, _expression),
    st.builds("y += {}".format, _expression),
    st.builds("log.append({})".format, _expression),
    st.builds("d[str({})] = {}".format, _expression, _expression),
    st.builds("assert x == x, {}".format, _expression),
    st.builds(
        "if x > {}: raise SyntaxError('no', ('f', {}, 1, 'x'))".format, _expression, _expression
    ),
    st.builds("if x > {}: return {}".format, _expression, _expression),
    st.builds("class A:\n    log.append(len(f'{{y}} and {{float({})}}'))".format, _number),
    st.builds("def g(): log.append(len(f'{{(yield {})}} {{x}}'))\nd['g'] = [*g()]".format, _number),
)
_body = st.recursive(_statement, _nested, max_leaves=6)

_FRAME = """
import contextlib, io, math
log = []
@contextlib.contextmanager
def here(): yield
def call(*a, k): return a[0] - k
def f(x, y=1.5):
    d = {}; z = 0; files = io
BODY
    return x, y, z, d
"""


def _program(body: str) -> str:
    return _FRAME.replace("BODY", "\n".join(f"    {line}" for line in body.split("\n")))


def _run(code: Any) -> Any:
    """What a program gives and logs, or how it fails, with the positions of its frames."""
    namespace: dict[str, Any] = {"__name__": "program"}
    exec(code, namespace)
    results = []
    for argument in (0.25, 3):
        try:
            results.append(repr(namespace["f"](argument)))
        except Exception as error:
            trace, positions = error.__traceback__, []
            while trace is not None:
                frame = trace.tb_frame
                if frame.f_code.co_filename == "program.py":
                    positions.append(list(frame.f_code.co_positions())[trace.tb_lasti // 2])
                trace = trace.tb_next
            results.append((repr(error), positions))
    return results, namespace


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(_body)
@example("log.append((y and 0.5 or 0.25))")
@example("log.append(((x and 0.5 or y) and 1.5 or z))")
@example("log.append((call(2.5, 1.5) and 0.5 or call(0.25, k=2.0)))")
@example("log.append((y and [x, 0.5][1] or 0.25))")
@example("return f'{x.conjugate()} and {y:.2f} ' + f'{str(x).join(str(y).split(str(2.5)))}!'")
@example("return f'{[q for q in (x, y)]} {(q * y for q in ()).__class__.__name__}'")
@example("return f'{(lambda q=y, *, r=x: q).__name__} {(z := x + 1)}'")
@example("""return f'{f"{x} {y.conjugate()}"} {f"{x}"!r:>{len(f"{y} {x}")}}'""")
@example("def g():\n    log.append(f'{(yield x)} {(yield y)!r:>9}')\nreturn [*g()]")
@example("def g(): log.append((yield x).StringIO('a').read())\nh = g()\nnext(h); h.send(io)")
@example("class A:\n    k = f'{y} {x.conjugate()}'\n    n = files.StringIO('a').read()\nreturn A.k")
@example("class A(io.StringIO):\n    def read(self): return super().read()\nreturn A('a').read()")
@example("return [q for q in [io]][0].StringIO('a').read()")
@example("return (q for q in [io]).__next__().StringIO('a').read()")
@example("return (lambda q=io: q).__defaults__[0].StringIO('a').read()")
@example("return x * 4 + (4 if y else 0)")
@example("raise SyntaxError('no', ('f', 3 + int(x), y + 5, 'text'))")
@example("return abs(max(y, (0.5 if x > 1 else 2.5)))")
@example("try: return y\nfinally: x = max(y, (0.5 if x > 1 else 2.5))")
def test_both_ways_do_what_plain_code_does(body: str) -> None:
    source = _program(body)
    plain = compile(source, "program.py", "exec", dont_inherit=True)
    expected, namespace = _run(plain)
    from_source, first = _run(
        hook.instrumented_code("program", "program.py", source.encode(), cached=False)
    )
    from_code, second = _run(instrumented_code_object(plain, "program"))
    assert from_code == expected
    assert from_source == expected
    assert repr(second["log"]) == repr(first["log"]) == repr(namespace["log"])
    for one, other in zip(first["log"], second["log"], strict=True):
        assert (provenance(one) is None) == (provenance(other) is None)
