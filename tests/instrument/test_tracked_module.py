"""`tracked_module` on code that was loaded plain: as under the import hook, and in place."""

import asyncio
import dataclasses
import enum
import functools
import importlib
import importlib.util
import inspect
import pickle
import sys
import textwrap
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from rosslt_auto import tracked_module
from rosslt_auto.instrument import hook, live, rewoven
from rosslt_auto.instrument.selection import Selection
from rosslt_auto.provenance import provenance, untracked
from rosslt_auto.provenance.values import is_tracked
from rosslt_auto.ros import weave


@pytest.fixture
def load(monkeypatch, tmp_path: Path) -> Iterator[Callable[[str], ModuleType]]:
    """Imports a source text as the plain module ``decorated``."""
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def load(source: str) -> ModuleType:
        sys.modules.pop("decorated", None)
        text = textwrap.dedent(source)
        (tmp_path / "decorated.py").write_text(text)
        importlib.invalidate_caches()
        return importlib.import_module("decorated")

    yield load
    sys.modules.pop("decorated", None)
    weave.uninstall()
    live.restore()


def places(value: Any) -> list[tuple[str, int, int]]:
    """Names and positions of the sources of a value."""
    assert is_tracked(value), value
    return [(one.parameter, one.line, one.column) for one in provenance(value).sources]


EVERYTHING = """
import dataclasses, enum, functools, sys
from contextlib import contextmanager
from typing import Generic, NamedTuple, TypeVar
from rosslt_auto import tracked_module

T = TypeVar("T")
{decorator}
class A(Generic[T]):
    "Doc."
    gain = 0.5
    a, b = 1.5, 2
    half = 1 / 2.0
    negative: float = -0.25
    __secret = 4.5
    offsets = [0.1, (0.2, 0.3)]
    table = {{"x": 1.0}}
    def __init__(self, x=1.25, *, y=2.5):
        self.x = x
        self.y = y + 3.0
    @property
    def doubled(self): return self.x * 2.0
    @doubled.setter
    def doubled(self, value): self.x = value / 2.0
    @staticmethod
    def static(k=7.0): return k + 7.5
    @classmethod
    def of_class(cls): return cls.gain * 8.0
    @functools.cached_property
    def cached(self): return 9.0
    @functools.lru_cache
    def remembered(self): return 10.0
    part = functools.partialmethod(lambda self, k: k * 11.0, len("xx"))
    def generator(self):
        for i in range(2):
            yield 12.0 + i
    async def later(self): return 12.5
    @contextmanager
    def managed(self): yield 12.75
    class Inner:
        value = 13.0
        def method(self): return 14.0 + self.value
    def secret(self): return self.__secret
    def above(self): return super().__hash__() and 15.0
    def local(self):
        class Local:
            def method(self, z=16.5): return 16.0 + z
        return Local().method()

{decorator}
@dataclasses.dataclass
class Data:
    x: float = 0.5
    y: float = dataclasses.field(default=1.5)
    def f(self): return self.x * 2

{decorator}
@dataclasses.dataclass(slots=True, frozen=True, kw_only=True)
class Frozen:
    x: float = 0.75
    def f(self): return self.x * 3.5

{decorator}
class Named(NamedTuple):
    x: float = 0.25
    def f(self): return self.x + 1.0

class Base:
    def inherited(self): return 17.0
{decorator}
class Derived(Base):
    def own(self): return 18.0

def wrapping(f):
    @functools.wraps(f)
    def inner(*a): return f(*a)
    return inner
{decorator}
@wrapping
def above(k=1.0): return k * 2.0
@wrapping
{decorator}
def below(k=1.0): return k * 3.0
def factory(z):
    {decorator}
    def inner(w=2.0, *, v=2.25): return w + v + 1.0
    return inner
{decorator}
@functools.singledispatch
def dispatched(x): return 19.0

a = A()
VALUES = lambda: [
    A.gain, A.a, A.b, A.half, A.negative, A.offsets[0], A.offsets[1][1], A.table["x"], a.x, a.y,
    a.doubled, a.static(), a.of_class(), a.cached, a.remembered(), a.part(), *a.generator(),
    a.managed().__enter__(), A.Inner.value, A.Inner().method(), a.secret(), a.above(), a.local(),
    Data().x, Data().y, Data.x, Data.y, Data().f(), dataclasses.fields(Data)[0].default,
    Frozen().x, Frozen().f(), Named().x, Named().f(), Named._field_defaults["x"],
    Derived().own(), above(), below(), factory(1.0)(), dispatched(1),
]
"""


def test_names_and_places_are_those_of_the_import_hook(load) -> None:
    decorated = load(EVERYTHING.format(decorator="@tracked_module"))
    found = decorated.VALUES()
    decorated.a.doubled = 5
    assert places(decorated.a.x)[0][0] == "rosslt.decorated.A.doubled.x"
    hook.install(Selection(patterns=["decorated"]))
    try:
        expected = load(EVERYTHING.format(decorator="@tracked_module")).VALUES()
    finally:
        hook.uninstall()
    plain = load(EVERYTHING.format(decorator="@(lambda thing: thing)")).VALUES()
    assert [untracked(value) for value in found] == plain
    assert [places(value) for value in found] == [places(value) for value in expected]


def test_a_module_that_is_imported_already(load) -> None:
    module = load(
        EVERYTHING.format(decorator="@(lambda thing: thing)")
        + "RATE = 30.0\nLIMITS = (1.0, 2.0)\nCHANGED = 1.0\ncallbacks = [lambda: 31.0]\n"
        "def closure(x):\n    def inner(): return x * 32.0\n    return {'kept': inner}\n"
        "kept = closure(2)\ndef change():\n    global CHANGED\n    CHANGED = 2.0\n"
    )
    assert tracked_module(module) is module
    values = [*module.VALUES(), module.RATE, module.LIMITS[1], module.callbacks[0](),
              module.kept["kept"](), module.Base().inherited()]  # fmt: skip
    values = [value for value in values if value not in (module.a.x, module.a.y)]  # made before
    assert not [value for value in values if not is_tracked(value)]
    assert not is_tracked(module.CHANGED)
    assert places(module.kept["kept"]()) == [("rosslt.decorated.closure.inner.inner", 106, 28)]


def test_what_is_not_its_code_stays_plain(load) -> None:
    module = load(EVERYTHING.format(decorator="@tracked_module"))
    assert not is_tracked(module.Derived().inherited())
    assert not is_tracked(module.Base().inherited())


def test_the_same_object_stays_what_it_was(load) -> None:
    source = """
    def decorate(thing): return thing
    def make(free):
        @decorate
        def f(a, /, b: float = 0.5, *args, k: "str" = "x", **kw) -> float:
            "Doc."
            return free * 2.0
        f.attribute = 1
        return f
    class C:
        "Doc."
        __slots__ = ("x",)
        y: float
        def m(self): return 1.0
    """
    module = load(source)
    f, cls = module.make(3), module.C
    before = [f.__name__, f.__qualname__, f.__doc__, f.__annotations__, f.__closure__, f.__dict__,
              f.__globals__, inspect.signature(f), inspect.getsource(f)]  # fmt: skip
    method = cls.m
    assert tracked_module(f) is f and tracked_module(cls) is cls
    after = [f.__name__, f.__qualname__, f.__doc__, f.__annotations__, f.__closure__, f.__dict__,
             f.__globals__, inspect.signature(f), inspect.getsource(f)]  # fmt: skip
    assert after == before
    assert f(1) == 6.0 and f.__code__.co_freevars == ("free",)
    assert cls.m is method and sorted(vars(cls)) == sorted(vars(load(source).C))


def test_pickled_by_reference(load) -> None:
    module = load(EVERYTHING.format(decorator="@tracked_module"))
    for thing in (module.A, module.above, module.A.Inner, module.A.static, module.Data):
        assert pickle.loads(pickle.dumps(thing)) is thing
    data = pickle.dumps(module.Data())
    assert b"rosslt" not in data and pickle.loads(data) == module.Data()


def test_async_functions(load) -> None:
    module = load(EVERYTHING.format(decorator="@tracked_module"))
    [(name, _, _)] = places(asyncio.run(module.a.later()))
    assert name == "rosslt.decorated.A.later.later"


def test_enumerations_are_left_alone(load) -> None:
    module = load("""
    import enum
    class Mode(enum.IntEnum):
        SLOW = 1
        FAST = 2
        def speed(self): return self.value * 0.5
    """)
    assert tracked_module(module.Mode) is module.Mode
    assert [type(mode.value) for mode in module.Mode] == [int, int]
    assert not any(is_tracked(mode.value) for mode in module.Mode)
    assert module.Mode(2) is module.Mode.FAST and isinstance(module.Mode, enum.EnumMeta)
    assert is_tracked(module.Mode.FAST.speed())


def test_what_has_changed_since_stays_plain(load) -> None:
    module = load("""
    class C:
        gain = 0.5
        twice = 1.0
        twice = 1.0
        kept = 2.0
        items = [1.0, 2.0]
        def f(self, k=0.5): return k
    def g(k=1.5): return k
    """)
    module.C.gain = 0.75
    module.C.kept = 2
    module.C.items.append(3.0)
    module.g.__defaults__ = (2.5,)
    tracked_module(module)
    for value in (module.C.gain, module.C.twice, module.C.kept, module.C.items[0], module.g()):
        assert not is_tracked(value), value
    assert is_tracked(module.C().f())
    assert (type(module.C.kept), module.C.items) == (int, [1.0, 2.0, 3.0])


def test_twice_is_once(load, monkeypatch) -> None:
    module = load("class C:\n    x = 0.5\n    def f(self, k=1.0): return k * 2.0\n")
    tracked_module(module.C)
    code, x, defaults = module.C.f.__code__, module.C.x, module.C.f.__defaults__
    tracked_module(module.C)
    tracked_module(module)
    assert module.C.f.__code__ is code and module.C.x is x
    assert module.C.f.__defaults__ is defaults


def test_nothing_to_do_under_the_import_hook(load, monkeypatch) -> None:
    hook.install(Selection(patterns=["decorated"]))
    try:
        with monkeypatch.context() as patch:
            patch.setattr(live, "rewoven", lambda *args: pytest.fail("done twice"))
            module = load(EVERYTHING.format(decorator="@tracked_module"))
            tracked_module(module)
    finally:
        hook.uninstall()
    assert is_tracked(module.above())


def test_a_file_is_rewritten_once(load, monkeypatch) -> None:
    count = []
    original = rewoven.rewritten_tree
    monkeypatch.setattr(rewoven, "rewritten_tree", lambda *args: count.append(1) or original(*args))
    load(
        "from rosslt_auto import tracked_module\n"
        + "".join(f"@tracked_module\ndef f{i}(x={i}.5): return x\n" for i in range(40))
    )
    assert len(count) == 1


@pytest.mark.parametrize("text", [None, "def f(): return 0.5\ndef g(k=3.5):\n    return 2.5\n"])
def test_source_that_is_gone_or_another_one(load, tmp_path: Path, text: str | None) -> None:
    module = load("def f(): return 0.5\ndef g(k=3.5): return 1.5 + k\n")
    if text is None:
        (tmp_path / "decorated.py").unlink()
    else:
        (tmp_path / "decorated.py").write_text(text)
    tracked_module(module)
    code = module.g.__code__
    tracked_module(module)
    assert module.g.__code__ is code
    assert (module.f(), module.g()) == (0.5, 5.0)
    [(name, line, _)] = places(module.g())
    assert (name.rpartition(".")[0], line) == ("rosslt.decorated.g", 2)
    assert is_tracked(module.f())


@pytest.mark.parametrize("thing", [0.5, "text", None, {}, sys])
def test_anything_else_is_refused(thing: Any) -> None:
    with pytest.raises(TypeError, match=r"tracked_module|Python code"):
        tracked_module(thing)


def test_errors_look_as_before(load) -> None:
    source = """
    def f(x):
        return (1.0
                / x)
    """

    def trace(module: ModuleType) -> list[Any]:
        with pytest.raises(ZeroDivisionError) as caught:
            module.f(0)
        frames = traceback.extract_tb(caught.tb)[1:]
        return [str(caught.value), [(f.lineno, f.colno, f.end_colno, f.line) for f in frames]]

    plain = trace(load(source))
    module = load(source)
    tracked_module(module.f)
    assert trace(module) == plain


def test_what_runs_goes_on(load) -> None:
    module = load("def f():\n    yield 1.0\n    yield 2.0\n")
    running = module.f()
    assert not is_tracked(next(running))
    tracked_module(module.f)
    assert not is_tracked(next(running)) and is_tracked(next(module.f()))


def test_a_wrapper_from_elsewhere_is_not_instrumented(load, tmp_path: Path) -> None:
    (tmp_path / "decorated_beside.py").write_text(
        "def wrapping(f):\n    def wrapper(): return f(), 1.0\n    return wrapper\n"
    )
    module = load("""
    from rosslt_auto import tracked_module
    from decorated_beside import wrapping
    @tracked_module
    @wrapping
    def f(): return 2.0
    """)
    own, theirs = module.f()
    assert is_tracked(own) and not is_tracked(theirs)
    del sys.modules["decorated_beside"]


def test_values_from_the_start_are_used(load) -> None:
    from rosslt_auto.provenance.registry import _initial, set_initial_values

    set_initial_values({"rosslt.decorated.C.gain": 0.75}, pytest.fail)
    try:
        module = load("class C:\n    gain = 0.5\n    half = 0.5\n")
        tracked_module(module.C)
    finally:
        _initial.clear()
    assert (module.C.gain, module.C.half) == (0.75, 0.5)


def test_generated_methods_follow(load) -> None:
    module = load(EVERYTHING.format(decorator="@tracked_module"))
    made = functools.reduce(lambda cls, value: cls(value), [1.0], module.Data)
    assert dataclasses.replace(made, y=2.0) == module.Data(1.0, 2.0)
    assert repr(module.Data()) == "Data(x=0.5, y=1.5)"
