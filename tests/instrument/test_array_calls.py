"""numpy and module `array` in instrumented programs: plain results, and provenance beside them."""

import array
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rosslt_auto.instrument import array_calls
from rosslt_auto.provenance.expressions import provenance
from rosslt_auto.provenance.values import is_tracked, untracked


@pytest.fixture(autouse=True)
def _woven() -> Iterator[None]:
    array_calls.install()
    yield
    array_calls.uninstall()


def test_values_and_types_are_the_plain_ones(instrumented: Callable[..., dict[str, Any]]) -> None:
    source = """
    import math
    import numpy as np
    from numpy import linalg
    from numpy.linalg import norm
    import numpy.linalg as la
    v = np.array([0.5, 2.0, 1.5])
    r = np.array([[math.cos(0.3), -math.sin(0.3)], [math.sin(0.3), math.cos(0.3)]])
    w = r @ v[:2]
    length = norm(v)
    again = linalg.norm(v), la.norm(v), np.linalg.norm(v)
    x = v[1]
    kinds = type(v), type(x), type(float(x)), type(length)
    number = math.sqrt(x)
    f = float(x)
    text = str(x)
    i = int(x)
    low = min(v[0], 3)
    """
    plain: dict[str, Any] = {}
    import textwrap

    exec(textwrap.dedent(source), plain)
    names = instrumented(source)
    for name in ("v", "r", "w", "length", "again", "x", "number", "f", "text", "i", "low"):
        assert repr(names[name]) == repr(plain[name]), name
    assert all(a is b for a, b in zip(names["kinds"], plain["kinds"], strict=True))
    for name in ("length", "x", "number", "f", "i"):
        assert is_tracked(names[name]), name
    assert type(untracked(names["f"])) is float


def test_where_an_element_comes_from(instrumented: Callable[..., dict[str, Any]]) -> None:
    names = instrumented("""
    import numpy as np
    gain = 3.0
    v = np.array([gain, 1.0]) * 2
    out = float(v[0])
    """)
    found = provenance(names["out"])
    assert found is not None
    assert found.sources[0].hint == "gain"
    solution = found.invert(8.0)
    assert {source.hint: value for source, value in solution.changes.items()} == {"gain": 4.0}


def test_module_array(instrumented: Callable[..., dict[str, Any]]) -> None:
    names = instrumented("""
    import array
    a = array.array("d", [0.5, 1.5])
    first = a[0]
    kind = type(a)
    """)
    assert names["a"] == array.array("d", [0.5, 1.5])
    assert names["kind"] is array.array
    assert is_tracked(names["first"])


PROGRAM = """
import sys
print("numpy" in sys.modules)
import numpy
print(numpy.__loader__.__class__.__name__, numpy.__spec__.loader.__class__.__name__)
print(sum(not type(finder).__module__.startswith("rosslt_auto") for finder in sys.meta_path))
a = numpy.array([0.5, 1.5])
print(a, repr(a), type(a), a.sum(), numpy.dot(a, a), numpy.linspace(0.0, 1.0, 3))
try:
    numpy.array([1.0, 2.0]) @ numpy.array([1.0])
except ValueError:
    import traceback
    traceback.print_exc()
"""


def test_a_program_sees_plain_numpy(tmp_path: Path, both: Callable[..., tuple[Any, Any]]) -> None:
    (tmp_path / "program.py").write_text(PROGRAM)
    plain, ours = both("program.py")
    assert ours == plain
    assert plain.status == 0 and plain.stdout.startswith("False")


def test_numpy_that_was_imported_before_is_woven_too() -> None:
    array_calls.uninstall()
    from rosslt_auto.instrument import calls

    assert id(np.array) not in calls._any
    array_calls.install()
    assert id(np.array) in calls._any
