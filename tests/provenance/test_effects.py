"""Where the change of a literal takes effect: the table of design 3.2, row by row."""

from __future__ import annotations

import math
import sys
import threading
from collections.abc import Iterator
from typing import Any

import pytest

from rosslt_auto.provenance import SourceChangeRefused, is_tracked, provenance, refresh, untracked
from rosslt_auto.provenance.registry import changed_locations, location_of
from support.programs import Program
from support.waiting import wait_until


@pytest.fixture
def load() -> Iterator[Any]:
    """Loads programs that are forgotten after the test."""
    loaded: list[Program] = []

    def load(source: str) -> Program:
        loaded.append(Program(source).__enter__())
        return loaded[-1]

    yield load
    for program in loaded:
        program.__exit__()


# Each program keeps a value computed from `a` = 2.0 somewhere; `read` gives what it now is: 3 * a.
KEPT = {
    "a name of the module": """
kept = <a=2.0> * 3
def read(): return kept
""",
    "a name of the module computed from another": """
A = <a=2.0>
B = A * 3
def read(): return B
""",
    "a class attribute": """
class K:
    kept = <a=2.0> * 3
def read(): return K.kept
""",
    "a class attribute read by a class method": """
class K:
    kept = <a=2.0> * 3
    @classmethod
    def read(cls): return cls.kept
class Sub(K): pass
def read(): return Sub.read()
""",
    "an attribute of an object": """
class K:
    def __init__(self): self.kept = <a=2.0> * 3
k = K()
def read(): return k.kept
""",
    "an attribute of an object in an object in a list": """
class Inner:
    def __init__(self): self.kept = <a=2.0> * 3
class Outer:
    def __init__(self): self.inners = [Inner()]
everything = {'here': (Outer(),)}
def read(): return everything['here'][0].inners[0].kept
""",
    "a slot": """
class K:
    __slots__ = ('kept', '__private', 'unset')
    def __init__(self):
        self.kept = <a=2.0>
        self.__private = self.kept * 3
    def read(self): return self.__private
k = K()
def read(): return k.read()
""",
    "a slot of a base class": """
class Base:
    __slots__ = 'kept'
class K(Base):
    __slots__ = ()
k = K()
k.kept = <a=2.0> * 3
def read(): return k.kept
""",
    "a field of a dataclass": """
from dataclasses import dataclass, field
@dataclass(frozen=True)
class K:
    kept: float = <a=2.0>
    more: tuple = ()
@dataclass(slots=True)
class L:
    k: K = field(default_factory=K)
    kept: float = 0.0
o = L(K())
o.kept = o.k.kept * 3
def read(): return o.kept if o.kept == o.k.kept * 3 == K().kept * 3 else None
""",
    "a named tuple": """
from collections import namedtuple
P = namedtuple('P', 'x y')
p = P(<a=2.0> * 3, 'y')
def read(): return p.x if type(p) is P else None
""",
    "nested containers": """
kept = {'list': [0, (1, [<a=2.0> * 3], {'deep': 1})]}
def read(): return kept['list'][1][1][0]
""",
    "a deque and a default dict": """
from collections import defaultdict, deque
kept = defaultdict(deque)
kept['x'].append(<a=2.0> * 3)
def read(): return kept['x'][0]
""",
    "a list that is named twice": """
one = two = [<a=2.0> * 3]
def read(): return one[0] if one is two else None
""",
    "a container that contains itself": """
kept = [<a=2.0> * 3]
kept.append(kept)
def read(): return kept[1][1][0]
""",
    "a default argument": """
def read(kept=<a=2.0> * 3): return kept
""",
    "a keyword's default": """
def read(*, kept=<a=2.0> * 3): return kept
""",
    "a default in a tuple": """
def read(kept=(1, <a=2.0> * 3)): return kept[1]
""",
    "a default of a method": """
class K:
    def read(self, kept=<a=2.0> * 3): return kept
def read(): return K().read()
""",
    "a default of a static method": """
class K:
    @staticmethod
    def read(kept=<a=2.0> * 3): return kept
def read(): return K.read()
""",
    "a default of a class method": """
class K:
    @classmethod
    def read(cls, kept=<a=2.0> * 3): return kept
def read(): return K.read()
""",
    "a property": """
class K:
    factor = <a=2.0>
    @property
    def kept(self, factor=3): return self.factor * factor
def read(): return K().kept
""",
    "a default of a property's getter": """
class K:
    @property
    def kept(self, value=<a=2.0> * 3): return value
def read(): return K().kept
""",
    "a closure": """
def outer():
    kept = <a=2.0> * 3
    def inner(): return kept
    return inner
read = outer()
""",
    "a closure of a wrapped function": """
import functools
def times(factor):
    def decorate(function):
        @functools.wraps(function)
        def wrapped(): return function() * factor
        return wrapped
    return decorate
@times(<a=2.0>)
def read(): return 3
""",
    "a closure that is only called back": """
class K:
    def __init__(self):
        kept = <a=2.0> * 3
        self.callbacks = [lambda: kept]
k = K()
def read(): return k.callbacks[0]()
""",
    "the arguments of a partial": """
import functools
def times(a, b): return a * b
read = functools.partial(times, <a=2.0>, b=3)
""",
    "the keywords of a partial": """
import functools
def times(a, b): return a * b
read = functools.partial(times, 3, b=<a=2.0>)
""",
    "a bound method's object": """
class K:
    def __init__(self): self.kept = <a=2.0> * 3
    def read(self): return self.kept
read = K().read
""",
    "an integer": """
kept = <a=2> * 3
def read(): return kept
""",
}


@pytest.mark.parametrize("where", KEPT)
def test_a_literal_executed_once(where: str, load: Any) -> None:
    """Every value computed from it that still has a name follows at once."""
    program = load(KEPT[where])
    read = program.module.read
    assert read() == 6
    for value in (5, 0, -1):
        program.change(a=value)
        assert read() == 3 * value
        assert type(untracked(read())) is type(untracked(program.location("a").first))
    [source] = provenance(read()).sources
    assert source is program.location("a")


def test_other_objects_are_left_alone(load: Any) -> None:
    """What is not the program's own is not looked through."""
    program = load("import fractions\nkept = <a=2.0> * 3\n")
    program.module.fractions.kept_by_somebody = program.module.kept
    try:
        program.change(a=5.0)
        assert program.module.fractions.kept_by_somebody == 6.0
    finally:
        del program.module.fractions.kept_by_somebody


def test_a_value_without_a_name_follows_when_it_is_published(load: Any) -> None:
    program = load("def make(): return kept * 3\nkept = <a=2.0>\n")
    value = program.module.make()
    assert refresh.refreshed(value) is value
    program.change(a=5.0)
    assert value == 6.0
    assert refresh.refreshed(value) == 15.0
    assert refresh.refreshed(refresh.refreshed(value)) == 15.0
    assert refresh.refreshed(1.5) == 1.5


def test_identity_is_kept_without_a_change(load: Any) -> None:
    program = load("kept = [<a=2.0>, (<b=3.0> * 2, 'x')]\nwhole = kept\n")
    pair, other = program.module.kept[1], program.module.kept[0]
    program.change(a=2.5)
    assert program.module.kept[1] is pair
    assert program.module.kept[0] is not other
    assert program.module.whole is program.module.kept


# ---------------------------------------------------------------- local variables


def test_locals_of_a_running_function(load: Any) -> None:
    program = load("""
def main(change):
    rate = <a=2.0>
    derived, pair = rate * 3, (rate, [rate * 3])
    change()
    return rate, derived, pair[0], pair[1][0]
""")
    found = program.module.main(lambda: program.change(a=5.0))
    assert found == (5.0, 15.0, 5.0, 15.0)
    assert all(map(is_tracked, found))


def test_locals_of_all_callers(load: Any) -> None:
    program = load("""
def main(change):
    outer = <a=2.0> * 3
    def inner(argument):
        local = argument + 1
        change()
        return argument, local, outer
    return *inner(outer), outer
""")
    found = program.module.main(lambda: program.change(a=5.0))
    assert found == (15.0, 16.0, 15.0, 15.0)


def test_locals_of_a_waiting_thread(load: Any) -> None:
    """The thread of a node that never spins, below a call into somebody else's code."""
    program = load("""
def main(started, go_on, found):
    kept = <a=2.0> * 3
    started.set()
    go_on.wait(10)
    found.append(kept)
""")
    started, go_on, found = threading.Event(), threading.Event(), []
    thread = threading.Thread(target=program.module.main, args=(started, go_on, found))
    thread.start()
    try:
        assert started.wait(10)
        wait_until(lambda: "wait" in innermost_function(thread), "the thread waits")
        program.change(a=5.0)
    finally:
        go_on.set()
        thread.join(10)
    assert found == [15.0]


def innermost_function(thread: threading.Thread) -> str:
    return sys._current_frames()[thread.ident].f_code.co_name


# ---------------------------------------------------------------- executed again and again


def test_a_literal_in_a_callback(load: Any) -> None:
    """What it has contributed stays; from its next execution on there is the new value."""
    program = load("""
class Node:
    def __init__(self):
        self.last = None
    def tick(self):
        self.last = <a=2.0?> * 3
node = Node()
""")
    node = program.module.node
    node.tick()
    node.tick()
    program.change(a=5.0)
    assert node.last == 6.0
    node.tick()
    assert node.last == 15.0


def test_a_literal_in_a_loop(load: Any) -> None:
    program = load("""
def main(change):
    results = []
    for i in range(4):
        results.append(<a=2.0*> * 3)
        if i == 1:
            change()
    return results
""")
    assert program.module.main(lambda: program.change(a=5.0)) == [6.0, 6.0, 15.0, 15.0]


def test_a_function_that_ran_once_counts_as_once(load: Any) -> None:
    """A set-up function: nothing but its execution count tells."""
    program = load("def setup():\n    return <a=2.0?> * 3\nkept = setup()\n")
    program.change(a=5.0)
    assert program.module.kept == 15.0


def test_both_kinds_in_one_value(load: Any) -> None:
    """Only the part that is executed once follows."""
    program = load("""
GAIN = <gain=10.0>
class Node:
    def tick(self):
        self.out = GAIN * <step=2.0*>
node = Node()
node.tick()
""")
    node = program.module.node
    program.change(step=3.0)
    assert node.out == 20.0
    program.change(gain=100.0)
    assert node.out == 200.0
    node.tick()
    assert node.out == 300.0


# ---------------------------------------------------------------- accumulated state

ACCUMULATORS = {
    "in place": "self.x += STEP",
    "with a factor": "self.x += STEP * 1.0",
    "to the right": "self.x = STEP + self.x",
    "over a local": "x = self.x; x = x + STEP; self.x = x",
    "subtracted": "self.x -= -STEP",
}


@pytest.mark.parametrize("steps", [2, 3, 10, 100, 1500, 5000])  # one is none yet
@pytest.mark.parametrize("how", ACCUMULATORS)
def test_accumulation(how: str, steps: int, load: Any) -> None:
    """What the step has added stays, the new step is added from now on; a change of the initial
    value shifts the state, once."""
    program = load(f"""
STEP = <step=0.5>
class Node:
    def __init__(self): self.x = <initial=10.0>
    def tick(self): {ACCUMULATORS[how]}
node = Node()
""")
    node = program.module.node
    for _ in range(steps):
        node.tick()
    assert node.x == 10.0 + steps * 0.5
    program.change(step=2.0)
    assert node.x == 10.0 + steps * 0.5
    for _ in range(3):
        node.tick()
    assert node.x == 16.0 + steps * 0.5
    program.change(initial=0.0)
    assert node.x == 6.0 + steps * 0.5
    node.tick()
    assert node.x == 8.0 + steps * 0.5
    program.change(initial=1.0, step=1.0)
    assert node.x == 9.0 + steps * 0.5


@pytest.mark.parametrize("steps", [3, 2000])
def test_accumulation_of_a_repeated_literal(steps: int, load: Any) -> None:
    program = load("""
class Node:
    def __init__(self): self.angle = <initial=0.0>
    def tick(self): self.angle += <step=0.5?>
node = Node()
""")
    node = program.module.node
    for _ in range(steps):
        node.tick()
    program.change(step=2.0)
    assert node.angle == steps * 0.5
    node.tick()
    program.change(initial=100.0)
    assert node.angle == 102.0 + steps * 0.5


def test_a_counter(load: Any) -> None:
    program = load("""
count = <initial=0>
def tick():
    global count
    count += <one=1?>
""")
    for _ in range(2000):
        program.module.tick()
    program.change(one=5)
    assert program.module.count == 2000
    program.module.tick()
    program.change(initial=-5)
    assert program.module.count == 2000
    assert type(untracked(program.module.count)) is int


# ---------------------------------------------------------------- never half done

TWO = """
kept = [<a=2.0> * 3, <b=3> + 1]
"""


@pytest.mark.parametrize(
    "wrong", [math.nan, math.inf, "5", None, True, [1.0], 1 + 2j], ids=repr
)  # fmt: skip
def test_a_refused_change_changes_nothing(wrong: Any, load: Any) -> None:
    program = load(TWO)
    before = list(program.module.kept)
    leaf = program.location("b").leaf
    for name, other in (("a", "b"), ("b", "a")):
        right = 7 if other == "b" else 7.0
        with pytest.raises(SourceChangeRefused, match=f"rosslt.*{name}"):
            program.change(**{other: right, name: wrong})
        with pytest.raises(SourceChangeRefused):
            program.change(**{name: wrong, other: right})
    assert all(new is old for new, old in zip(program.module.kept, before, strict=True))
    assert program.location("b").leaf is leaf
    assert program.location("a").value == 2.0
    assert program.location("a") not in changed_locations()


def test_kinds(load: Any) -> None:
    """An int for a float is converted, a float for an int refused."""
    program = load(TWO)
    program.change(a=4)
    assert program.module.kept[0] == 12.0
    assert type(program.location("a").value) is float
    for wrong in (4.0, 2**63, -(2**63) - 1):
        with pytest.raises(SourceChangeRefused):
            program.change(b=wrong)
    program.change(b=-(2**63))
    assert program.module.kept[1] == -(2**63) + 1
    with pytest.raises(SourceChangeRefused):
        program.change(a=10**400)


def test_a_value_without_a_result_stays(load: Any) -> None:
    """All others follow."""
    program = load("A = <a=2.0>\nkept = [1 / A, A * 3, A ** -1]\n")
    program.change(a=0.0)
    assert program.module.kept == [0.5, 0.0, 0.5]
    program.change(a=4.0)
    assert program.module.kept == [0.25, 12.0, 0.25]


def test_a_value_never_changes_its_type(load: Any) -> None:
    """An expression may give another type with other values: 2 ** -1 is a float."""
    program = load("kept = 2 ** <a=3>\n")
    program.change(a=-1)
    assert untracked(program.module.kept) == 8
    program.change(a=4)
    assert untracked(program.module.kept) == 16


def test_several_changes_take_effect_together(load: Any) -> None:
    program = load("LOW, HIGH = <low=1.0>, <high=2.0>\nkept = 1 / (HIGH - LOW)\n")
    program.change(low=2.0, high=4.0)
    assert program.module.kept == 0.5


def test_what_is_known_of_locations(load: Any) -> None:
    program = load(TWO)
    location = program.location("a")
    assert location_of(location.parameter) is location
    assert location_of("rosslt.nothing") is None
    assert location not in changed_locations()
    program.change(a=5.0)
    assert location in changed_locations()
    assert (location.first, location.value) == (2.0, 5.0)
    program.change(a=2.0)
    assert location not in changed_locations()
