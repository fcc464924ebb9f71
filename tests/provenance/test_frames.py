"""Functions that nobody sees."""

import cProfile
import inspect
import pstats
import sys
import traceback
import warnings

import pytest

from rosslt_auto.provenance import provenance
from rosslt_auto.provenance.frames import unseen, without_ours
from support.tracked import tracked


@unseen
def divide(a, b, then=None):
    """Long enough for jumps that need an extended argument."""
    if then is not None:
        return then()
    try:
        if b == "wrong":
            raise KeyError(b)
    except KeyError:
        try:
            a = a + 1 - 1
        finally:
            b = 1
    for _ in range(2):
        c = a + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0
        c = c + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0
        c = c + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0 + 0
    return c / b


def test_it_still_computes() -> None:
    assert divide(6, 3) == 2
    assert divide(6, "wrong") == 6


def test_tracebacks() -> None:
    with pytest.raises(ZeroDivisionError) as caught:
        divide(1, 0)
    assert [frame.name for frame in traceback.extract_tb(caught.tb)] == ["test_tracebacks"]


def test_stacks() -> None:
    names = divide(1, 1, lambda: [frame.function for frame in inspect.stack()])
    assert names[:2] == ["<lambda>", "test_stacks"]
    assert divide(1, 1, lambda: sys._getframe(1).f_code.co_name) == "test_stacks"


def test_stack_levels_of_warnings() -> None:
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        divide(1, 1, lambda: warnings.warn("here", stacklevel=2))
    assert seen[0].filename == __file__


def test_twice_is_once() -> None:
    code = divide.__code__
    assert unseen(divide).__code__ is code


def test_profilers_see_balanced_calls() -> None:
    def caller():
        for _ in range(10):
            divide(1, 1)

    profile = cProfile.Profile()
    profile.runcall(caller)
    calls = {key[2]: row[0] for key, row in pstats.Stats(profile).stats.items()}
    assert calls["caller"] == 1


def test_tracers_see_balanced_calls() -> None:
    depth = 0
    depths = []

    def trace(frame, event, arg):
        nonlocal depth
        depth += {"call": 1, "return": -1}.get(event, 0)
        depths.append(depth)
        return trace

    def caller():
        try:
            return divide(1, 1) + divide(1, int(sys.version_info >= (3, 12)))
        except ZeroDivisionError:
            return divide(1, 1)

    old = sys.gettrace()
    sys.settrace(trace)
    try:
        caller()
    finally:
        sys.settrace(old)
    assert min(depths) >= 0
    assert depths[-1] == 0


def test_errors_of_overloaded_operators() -> None:
    from rosslt_auto.instrument import calls  # makes them unseen
    from rosslt_auto.provenance.values import leaf

    assert calls
    x = leaf(object(), 2.0)
    with pytest.raises(ZeroDivisionError) as caught:
        x % 0.0
    assert len(traceback.extract_tb(caught.tb)) == 1


def test_frames_of_ours_can_be_left_out() -> None:
    """Of an interrupt that struck while an expression was being evaluated."""

    class Interrupting(dict[str, float]):
        def __bool__(self) -> bool:
            return True

        def __getattribute__(self, name: str) -> object:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as raised:
        provenance(tracked(1.5, "gain") * 2.0).evaluate(Interrupting())
    trace = raised.value.__traceback__
    assert any("rosslt_auto/provenance" in one.filename for one in traceback.extract_tb(trace))
    left = [frame.name for frame in traceback.extract_tb(without_ours(trace))]
    assert left == ["test_frames_of_ours_can_be_left_out", "__getattribute__"]
