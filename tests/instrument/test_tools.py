"""Debuggers, profilers, coverage and the like see a program as if it was not instrumented."""

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.modules import write_modules

PROGRAM = '''
import math, warnings
from helper import Shape, area, deep

GAIN = 0.5

def compute(x, k=1.5):
    """Computes.

    >>> compute(2.0)
    3.5
    >>> GAIN, type(GAIN), [GAIN], f"{GAIN:.2f}"
    (0.5, <class 'float'>, [0.5], '0.50')
    >>> compute("a")
    Traceback (most recent call last):
    TypeError: can't multiply sequence by non-int of type 'float'
    """
    y = x * k
    if y > 1.0:
        y = float(y) + math.sqrt(
            GAIN * 0.5
        ) \\
            + 0.0
    else:
        y = 2
    return y

def main():
    total = 0
    for i in range(3):
        total += compute(i + 0.5)
    shape = Shape(2.0)
    total += area(shape)
    warnings.warn("here" + " there", stacklevel=1)
    deep(3)
    print(total, [round(x * 1.5, 2) for x in (1, 2)], min(1.0, total), f"{total:.1f}")
    return total

def failing():
    for call, argument in (compute, "a"), (area, Shape(1e300)):
        try:
            call(argument)
        except (TypeError, OverflowError) as error:
            print(error)
'''
HELPER = """
import math, warnings
class Shape:
    factor = 3.25
    def __init__(self, r=1.0):
        self.r = r
    @property
    def square(self):
        return self.r ** 2
def area(shape):
    try:
        return (shape.square
                * math.pi
                * shape.factor)
    finally:
        warnings.warn("caller", DeprecationWarning, stacklevel=2)
def deep(n):
    if n == 0:
        warnings.warn("top", stacklevel=4)
        return 0.5
    return deep(n - 1) + 1.0
"""
TOOLS = """
import os, sys
import program, helper
FILES = {"program.py", "helper.py"}
events = []
def note(*event):
    events.append(event)

def trace(with_errors):
    def tracer(frame, event, arg):
        assert frame.f_lineno is not None
        code = frame.f_code
        if os.path.basename(code.co_filename) in FILES:
            note(event, code.co_name, frame.f_lineno)
        return tracer
    sys.settrace(tracer)
    program.main()
    with_errors and program.failing()
    sys.settrace(None)

def profile():
    def profiler(frame, event, arg):
        if os.path.basename(frame.f_code.co_filename) in FILES and event in ("call", "return"):
            note(event, frame.f_code.co_name, frame.f_lineno)
    sys.setprofile(profiler)
    program.main()
    sys.setprofile(None)

def cprofile():
    import cProfile, pstats
    profiler = cProfile.Profile()
    profiler.runcall(program.main)
    for (file, line, name), (calls, total, *_) in pstats.Stats(profiler).stats.items():
        if os.path.basename(file) in FILES:
            note(name, line, calls, total)
    events.sort()

def monitor():
    monitoring = sys.monitoring
    monitoring.use_tool_id(4, "test")
    chosen = 0
    for name in ("LINE", "PY_START", "PY_RETURN"):
        event = getattr(monitoring.events, name)
        def callback(code, *rest, name=name):
            if os.path.basename(code.co_filename) in FILES:
                note(name, code.co_name, rest[0] if name == "LINE" else "")
        monitoring.register_callback(4, event, callback)
        chosen |= event
    monitoring.set_events(4, chosen)
    program.main()
    program.failing()
    monitoring.set_events(4, 0)

def count():
    import trace
    tracer = trace.Trace(count=1, trace=0)
    tracer.runfunc(program.main)
    tracer.runfunc(program.failing)
    for (file, line), times in sorted(tracer.results().counts.items()):
        if os.path.basename(file) in FILES:
            note(file, line, times)

def inspected():
    import inspect
    things = (program.compute, helper.Shape, helper.Shape.square.fget, helper.deep, program)
    for thing in things:
        note(inspect.getsource(thing), inspect.getsourcelines(thing)[1], inspect.getdoc(thing))
        if callable(thing):
            note(inspect.signature(thing), inspect.getmodule(thing).__name__)
    note(inspect.getmembers(helper.Shape(), lambda value: isinstance(value, float)))
    variables = inspect.getclosurevars(program.compute)
    note(sorted(variables.globals), variables.nonlocals, variables.unbound)
    note(inspect.getfullargspec(program.compute), inspect.getattr_static(helper.Shape, "factor"))
    for function in (program.compute, helper.deep, helper.area):
        code = function.__code__
        note(sorted({line for *_, line in code.co_lines() if line}), code.co_varnames)

def namespaces():
    import pickle
    a = 1.5
    note(sorted(locals()), dir())
    class C:
        k = 0.5
        inside = sorted(locals()), dir(), sorted(vars())
    note(C.inside, sorted(vars(C)), [sorted(locals()) for i in (0.5, a)])
    note(sorted(globals()), dir(program), sorted(vars(helper.Shape)), vars(helper.Shape()))
    for made in (program.GAIN, C.k, helper.Shape(1.5)):
        data = pickle.dumps(made)
        note(b"@" in data, b"rosslt" in data, type(pickle.loads(data)), dir(made))

if __name__ == "__main__":
    eval(sys.argv[1])
    print(*events, sep="\\n")
"""
AFTER_3_11 = pytest.mark.skipif(sys.version_info < (3, 12), reason="sys.monitoring is new in 3.12")
TOLD_OF_ERRORS = pytest.mark.xfail(
    sys.version_info >= (3, 12),
    reason="3.12 tells tracers of errors that leave an unseen frame as if they left the caller",
    strict=True,
)


@pytest.fixture
def program(tmp_path: Path) -> Iterator[None]:
    write_modules(tmp_path, {"program": PROGRAM, "helper": HELPER, "tools": TOOLS})
    yield


@pytest.mark.parametrize(
    "mode",
    [
        "trace(False)",
        pytest.param("trace(True)", marks=TOLD_OF_ERRORS),
        "profile()",
        "cprofile()",
        pytest.param("monitor()", marks=AFTER_3_11),
        "count()",
        "inspected()",
        "namespaces()",
    ],
)
def test_what_tools_are_told(both, program: None, mode: str) -> None:
    plain, ours = both("tools.py", mode)
    assert plain.status == 0 and len(plain.stdout.splitlines()) > 4, plain
    assert ours == plain


COMMANDS = """
break program.compute
tbreak helper.py:11
continue
args
p x, k, GAIN, type(k)
pp {"gain": GAIN, "k": [k]}
whatis k
next
next
step
p sorted(locals()), [name for name in globals() if "@" in name]
longlist
return
retval
clear 1
continue
up
p shape.r, shape.__dict__
list
down
source Shape
display shape.factor
step
next
undisplay shape.factor
!shape.r = 3.5
continue
"""


def test_a_debugger(both, tmp_path: Path, program: None) -> None:
    (tmp_path / "debugged.py").write_text("import program\nbreakpoint()\nprogram.main()\n")
    plain, ours = both("debugged.py", input=COMMANDS)
    assert plain.status == 0 and plain.stdout.count("(Pdb)") > 20, plain
    assert ours == plain


def test_a_debugger_after_the_end(both, tmp_path: Path) -> None:
    (tmp_path / "failing.py").write_text(
        "import pdb, sys\n"
        "def f(x, k=0.5):\n    return x / (k - 0.5)\n"
        "try: f(1.5)\nexcept ZeroDivisionError: pdb.post_mortem(sys.exc_info()[2])\n"
    )
    plain, ours = both("failing.py", input="p x, k\nup\nlist\nargs\nq\n")
    assert "-> return x / (k - 0.5)" in plain.stdout
    assert ours == plain


def test_doctest(both, program: None) -> None:
    options = ("--module", "program", "--module", "helper")
    plain, ours = both("-m", "doctest", "-v", "program.py", options=options)
    assert plain.status == 0 and "3 passed" in plain.stdout, plain
    assert ours == plain
