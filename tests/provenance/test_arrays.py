"""Arrays of numpy: the values are plain numpy's, the elements know where they came from."""

import copy
import math
import pickle
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rosslt_auto.provenance import Source, arrays, is_tracked, provenance, untracked
from rosslt_auto.provenance.array_names import CALLS
from rosslt_auto.provenance.expressions import evaluate
from rosslt_auto.provenance.inversion import NotInvertible, invert
from rosslt_auto.provenance.values import leaf

SOURCES = {name: Source("/node", name, "float") for name in "xyzk"}
VALUES = {"x": 1.5, "y": 2.5, "z": -0.5, "k": 2.0}


@pytest.fixture(autouse=True, scope="module")
def installed() -> Iterator[None]:
    arrays.install()
    yield
    arrays.uninstall()


def tracked(name: str) -> Any:
    return leaf(SOURCES[name], VALUES[name])


@pytest.fixture
def xyz() -> Any:
    return [tracked(name) for name in "xyz"]


class Advised:
    """numpy as instrumented code calls it."""

    def __getattr__(self, name: str) -> Any:
        found = getattr(np, name)
        if name == "linalg":
            return AdvisedLinalg()
        if isinstance(found, type):  # a type of elements, not called here
            return found
        return arrays.ADVICE.get(id(found), found)


class AdvisedLinalg:
    def __getattr__(self, name: str) -> Any:
        found = getattr(np.linalg, name)
        return arrays.ADVICE.get(id(found), found)


ANP: Any = Advised()


def texts(array: Any) -> list[Any]:
    """The expression of each element that has provenance, the value of the others."""
    found = arrays.elements(array)
    if found is None:
        return []
    return [provenance(e).expression if is_tracked(e) else e for e in found]


def text(value: Any) -> str:
    found = provenance(value)
    assert found is not None
    return found.expression


# ---------------------------------------------------------------- against plain numpy

SMOOTH: dict[str, Callable[[Any, Any, Any, Any], Any]] = {
    "add": lambda np, a, b, k: a + b,
    "sub": lambda np, a, b, k: a - b,
    "mul": lambda np, a, b, k: a * b,
    "div": lambda np, a, b, k: a / (b * b + 1.0),
    "scalar left": lambda np, a, b, k: k * a,
    "scalar right": lambda np, a, b, k: a - k,
    "numpy scalar": lambda np, a, b, k: np.float64(3.0) * k + a,
    "power": lambda np, a, b, k: a**2,
    "neg": lambda np, a, b, k: -a,
    "sin": lambda np, a, b, k: np.sin(a),
    "arctan2": lambda np, a, b, k: np.arctan2(a, k),
    "sqrt": lambda np, a, b, k: np.sqrt(a * a + 1),
    "square": lambda np, a, b, k: np.square(a),
    "outer": lambda np, a, b, k: np.outer(a, b).reshape(-1)[: a.size].reshape(a.shape),
    "matmul": lambda np, a, b, k: a @ b.T @ b,
    "dot": lambda np, a, b, k: np.dot(a, b.T).dot(b),
    "inner": lambda np, a, b, k: np.inner(a, b) @ a,
    "plain matmul": lambda np, a, b, k: np.eye(2)[::-1] @ a,
    "sum": lambda np, a, b, k: a + a.sum(axis=0),
    "sum all": lambda np, a, b, k: np.sum(a) + b,
    "mean": lambda np, a, b, k: a - np.mean(a, axis=1, keepdims=True),
    "prod": lambda np, a, b, k: a * np.prod(b, 1)[:, None],
    "cumsum": lambda np, a, b, k: np.cumsum(a, axis=1),
    "diff": lambda np, a, b, k: np.concatenate([a[:, :1], np.diff(a)], axis=1),
    "cross": lambda np, a, b, k: np.cross(a, b),
    "einsum": lambda np, a, b, k: np.einsum("ij,kj->ik", a, b) @ a,
    "trace": lambda np, a, b, k: a * np.trace(a @ b.T),
    "norm": lambda np, a, b, k: a / (1.0 + np.linalg.norm(b)),
    "norm axis": lambda np, a, b, k: a / (1.0 + np.linalg.norm(b, axis=1))[:, None],
    "row": lambda np, a, b, k: a[1] + b,
    "column": lambda np, a, b, k: a[:, 1:2] * b,
    "element": lambda np, a, b, k: a[0, 1] + b[-1, 2] * a,
    "fancy": lambda np, a, b, k: a[[1, 0]] + b[:, [2, 0, 1]],
    "transpose": lambda np, a, b, k: a.T.copy().T,
    "reshape": lambda np, a, b, k: a.reshape(3, 2).reshape(2, -1) + b.ravel().reshape((2, 3)),
    "concatenate": lambda np, a, b, k: np.concatenate([a[:1], b[1:]]),
    "stack": lambda np, a, b, k: np.stack([a[0], b[1]]),
    "vstack": lambda np, a, b, k: np.vstack((a[1], np.ones(3))),
    "hstack": lambda np, a, b, k: np.hstack([a, b])[:, 2:5],
    "roll": lambda np, a, b, k: np.roll(a, 1),
    "flip": lambda np, a, b, k: np.flip(a, 0),
    "swapaxes": lambda np, a, b, k: a.swapaxes(0, 1).swapaxes(0, 1),
    "squeeze": lambda np, a, b, k: np.squeeze(np.expand_dims(a, 0)),
    "diag": lambda np, a, b, k: np.diag(np.diag(a[:, :2])) @ b,
    "repeat": lambda np, a, b, k: np.repeat(a, 2, axis=0)[1:3],
    "from list": lambda np, a, b, k: np.array([[k, 1.0, k * 2], [a[0, 0], 3, k]]),
    "from rows": lambda np, a, b, k: np.array([a[0], b[1]]),
    "linspace": lambda np, a, b, k: a + np.linspace(k, 4.0, 3),
    "zeros filled": lambda np, a, b, k: filled(np.zeros((2, 3)), a, k),
    "in place": lambda np, a, b, k: in_place(a.copy(), b, k),
    "in place of a row": lambda np, a, b, k: row_in_place(a.copy(), b, k),
    "to float32": lambda np, a, b, k: a.astype(np.float32),
    "integers": lambda np, a, b, k: np.arange(6).reshape(2, 3) * a,
    "nested": lambda np, a, b, k: np.array([float(i) for i in range(3)]) + a,
    "kron": lambda np, a, b, k: np.kron(a, [1.0, 0.5])[:, :3],
    "append": lambda np, a, b, k: np.append(a[:1], b[1:], axis=0),
    "out": lambda np, a, b, k: np.add(a, k, out=np.empty((2, 3))),
    "full": lambda np, a, b, k: np.full((2, 3), k) + a,
    "rotation": lambda np, a, b, k: a @ np.array(
        [[np.cos(k), -np.sin(k), 0], [np.sin(k), np.cos(k), 0], [0, 0, 1]]
    ),
}  # fmt: skip
BRANCHING: dict[str, Callable[[Any, Any, Any, Any], Any]] = {
    "minimum": lambda np, a, b, k: np.minimum(a, b),
    "maximum": lambda np, a, b, k: np.maximum(a, k),
    "clip": lambda np, a, b, k: np.clip(a, -1.0, k),
    "clip method": lambda np, a, b, k: a.clip(0.0, 3.0),
    "where": lambda np, a, b, k: np.where(a > b, a, k),
    "max": lambda np, a, b, k: a - a.max(axis=0),
    "min": lambda np, a, b, k: a + np.min(a),
    "sort": lambda np, a, b, k: np.sort(a),
    "abs": lambda np, a, b, k: np.abs(a),
    "mask": lambda np, a, b, k: masked(a.copy(), k),
    "floor": lambda np, a, b, k: np.floor(a),
    "round": lambda np, a, b, k: np.round(a, 2),
    "floordiv": lambda np, a, b, k: a // k,
    "mod": lambda np, a, b, k: a % 3.0,
    "std": lambda np, a, b, k: a - np.std(a),
    "argmax": lambda np, a, b, k: a + np.argmax(a),
    "inverse": lambda np, a, b, k: np.linalg.inv(a @ a.T + 3 * np.eye(2)) @ b,
    "median": lambda np, a, b, k: a - np.median(b),
    "compare": lambda np, a, b, k: a * (a > k),
    "sorted in place": lambda np, a, b, k: sorted_in_place(a.copy()),
    "divide by zero": lambda np, a, b, k: a / (b - b),
}


def filled(array: Any, a: Any, k: Any) -> Any:
    array[0, 1] = k
    array[1, :] = a[0]
    array[0, 2] = a[1, 1] * 2
    return array


def in_place(a: Any, b: Any, k: Any) -> Any:
    a += b
    a *= k
    a[0] -= 1.0
    return a


def row_in_place(a: Any, b: Any, k: Any) -> Any:
    row = a[1]
    row[0] = k
    row += b[0]
    return a


def masked(a: Any, k: Any) -> Any:
    a[a > 1.0] = k
    return a


def sorted_in_place(a: Any) -> Any:
    a.sort()
    return a


def run(numpy: Any, steps: list[tuple[str, int]], numbers: list[Any], k: Any) -> list[Any]:
    """The arrays that a random program makes."""
    made = [numpy.array([numbers[:3], numbers[3:]]), numpy.array([[1.0, 2.0, 0.5], [0.0, k, -1.0]])]
    for name, choice in steps:
        step = (SMOOTH | BRANCHING)[name]
        made.append(step(numpy, made[choice % len(made)], made[-1], k))
    return made


def numbers_of(values: dict[str, float], make: Callable[[str], Any]) -> list[Any]:
    return [make("x"), 2.0, make("y"), make("z") * make("x"), -1.25, make("y") + 1.0]


def steps_of(names: Any) -> Any:
    return st.lists(st.tuples(st.sampled_from(sorted(names)), st.integers(0, 5)), max_size=4)


def same(a: Any, b: Any) -> bool:
    """Equal bit for bit, type and shape."""
    a, b = np.asarray(a), np.asarray(b)
    return a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes()


@settings(max_examples=150, deadline=None)
@given(steps_of(SMOOTH | BRANCHING))
def test_values_are_those_of_plain_numpy(steps: Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        plain = run(np, steps, numbers_of(VALUES, VALUES.__getitem__), VALUES["k"])
        found = run(ANP, steps, numbers_of(VALUES, tracked), tracked("k"))
    for a, b in zip(plain, found, strict=True):
        assert same(a, b)
        assert type(b) == type(a)  # noqa: E721
        assert a.flags.c_contiguous == b.flags.c_contiguous
        assert a.flags.writeable == b.flags.writeable
        assert repr(a) == repr(b)


@settings(max_examples=150, deadline=None)
@given(
    steps_of(SMOOTH),
    st.fixed_dictionaries({n: st.floats(-3, 3).map(lambda v: round(v, 3)) for n in "xyzk"}),
)
def test_expressions_of_elements_follow_their_sources(
    steps: Any, changed: dict[str, float]
) -> None:
    """Evaluated with other values of the sources they give what the program would compute."""
    found = run(ANP, steps, numbers_of(VALUES, tracked), tracked("k"))
    changes = {SOURCES[name]: value for name, value in changed.items()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        wanted = run(np, steps, numbers_of(changed, changed.__getitem__), changed["k"])
    coarse = any(name == "to float32" for name, _ in steps)
    for array, goal in zip(found, wanted, strict=True):
        elements = arrays.elements(array) or array.reshape(-1).tolist()
        largest = max(1.0, float(np.abs(goal).max()))
        for element, number in zip(elements, goal.reshape(-1).tolist(), strict=True):
            got = evaluate(element, changes)
            assert math.isclose(got, number, rel_tol=1e-9, abs_tol=1e-10 * largest) or (
                coarse and math.isclose(got, number, rel_tol=1e-3, abs_tol=1e-5 * largest)
            )


@settings(max_examples=100, deadline=None)
@given(steps_of(SMOOTH | BRANCHING))
def test_expressions_have_the_values_of_their_elements(steps: Any) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found = run(ANP, steps, numbers_of(VALUES, tracked), tracked("k"))
    for array in found:
        elements = arrays.elements(array)
        for element, value in zip(
            elements or [], arrays.plain(array).reshape(-1).tolist(), strict=False
        ):
            assert untracked(element) == value or value != value
            assert type(untracked(element)) is type(value)
            if is_tracked(element) and math.isfinite(value):
                again = evaluate(element, {SOURCES[n]: v for n, v in VALUES.items()})
                tolerance = 1e-9 if array.dtype == np.float64 else 1e-5
                assert math.isclose(again, value, rel_tol=tolerance, abs_tol=1e-6)


@pytest.mark.parametrize("name", sorted(SMOOTH))
def test_a_reachable_element_is_reached(name: str) -> None:
    found = SMOOTH[name](
        ANP, ANP.array([[tracked("x"), 2.0, tracked("y")], [0.5, tracked("z"), -1.25]]),
        ANP.array([[1.0, 2.0, 0.5], [0.25, tracked("k"), -1.0]]), tracked("k"),
    )  # fmt: skip
    elements = [e for e in arrays.elements(found) or [] if is_tracked(e)]
    assert elements, "provenance has ended"
    solved = 0
    for element in elements:
        source = provenance(element).sources[0]
        target = evaluate(element, {source: VALUES[source.parameter] + 0.125})
        if target == untracked(element):  # multiplied by zero
            continue
        solution = provenance(element).invert(target, source=source.parameter)
        assert math.isclose(solution.value, target, rel_tol=1e-9, abs_tol=1e-9)
        solved += bool(solution.changes)
    assert solved


# ---------------------------------------------------------------- single things


def test_a_transform(xyz: Any) -> None:
    transform = ANP.eye(4)
    transform[:3, 3] = xyz
    transform[0, 1] = tracked("k")
    found = transform @ ANP.array([1.0, 2.0, 3.0, 1.0])
    assert texts(found) == ["1.0 + k * 2.0 + x", "y + 2.0", "z + 3.0", 1.0] or texts(found) == [
        "k * 2.0 + x + 1.0", "y + 2.0", "z + 3.0", 1.0,
    ]  # fmt: skip
    assert found.tolist() == [1.0 + 4.0 + 1.5, 4.5, 2.5, 1.0]


def test_elements_are_scalars_of_numpy(xyz: Any) -> None:
    element = ANP.array(xyz)[1]
    assert type(element) == np.float64  # noqa: E721
    assert isinstance(element, np.floating) and isinstance(element, float)
    assert text(element) == "y"
    assert repr(element) == repr(np.float64(2.5)) and f"{element:.2f}" == "2.50"
    assert element.item() is xyz[1]
    assert type(pickle.loads(pickle.dumps(element))) is np.float64
    assert hash(element) == hash(2.5)


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64])
def test_scalars_compute_like_numpys(kind: Any) -> None:
    plain, count = kind(7), leaf(Source("/n", "count", "int"), 3)
    element = ANP.array([count])[0]
    for operate in (
        lambda a, b: a + b, lambda a, b: a - b, lambda a, b: a * b, lambda a, b: a / b,
        lambda a, b: a // b, lambda a, b: a % b, lambda a, b: a**b,
    ):  # fmt: skip
        for number in (count, element):
            for a, b in ((plain, number), (number, plain)):
                found, wanted = operate(a, b), operate(untracked(a), untracked(b))
                assert type(found) == type(wanted) and found == wanted  # noqa: E721
                assert is_tracked(found)
                again = evaluate(found, {Source("/n", "count", "int"): 3})
                assert math.isclose(again, wanted, rel_tol=1e-6)


def test_plain_scalars_and_arrays_meet_tracked_numbers() -> None:
    k = tracked("k")
    assert text(np.float64(3.0) * k) == "3.0 * k"
    assert text(np.float32(3.0) * k) == "3.0 * k"
    assert texts(np.arange(2.0) - k) == ["0.0 - k", "1.0 - k"]
    assert texts(k / np.array([1.0, 4.0])) == ["k / 1.0", "k / 4.0"]
    assert text(np.sin(k)) == "sin(k)"
    assert text(np.hypot(k, 1.0)) == "hypot(k, 1.0)"
    assert text(np.clip(k, 0.0, 9.0)) == "min(max(k, 0.0), 9.0)"
    assert text(np.clip(k, None, 9.0)) == text(np.minimum(k, 9.0)) == "min(k, 9.0)"
    with pytest.raises(NotInvertible, match=r"limited to 9\.0"):
        invert(np.clip(k, 0.0, 9.0), 10.0)
    assert list(invert(np.clip(k * k, 0.0, 9.0), np.float64(6.25)).changes.values()) == [2.5]
    array = before = np.ones(2)
    array *= k
    assert array is before and array.tolist() == [2.0, 2.0]
    assert (np.arange(3) < k).tolist() == [True, True, False]


def test_nothing_tracked_stays_plain() -> None:
    assert type(ANP.sin(1.0)) is np.float64
    assert type(ANP.concatenate([[1.0], [2.0]])) is np.ndarray
    assert type(ANP.zeros(3) + 1) is np.ndarray
    assert arrays.elements(np.ones(3)) is None and not arrays.has_provenance(np.ones(3))
    assert arrays.elements(ANP.zeros(3)) is None and not arrays.has_provenance(ANP.zeros(3))
    assert arrays.elements([tracked("x")]) is None
    assert type(ANP.array(["a"])) is np.ndarray and type(ANP.array([1j])) is np.ndarray


def test_a_change_behind_our_back_ends_provenance(xyz: Any) -> None:
    array = ANP.array(xyz)
    memoryview(array)[1] = 7.0
    assert texts(array) == ["x", 7.0, "z"]
    assert not is_tracked(array[1])
    assert texts(array * 2) == ["x * 2", 14.0, "z * 2"]


def test_assignments_through_views_reach_the_array() -> None:
    array = ANP.zeros((2, 2))
    array[1][0] = tracked("x")
    array.T[1, 0] = tracked("y")
    array.reshape(-1)[3] = tracked("z")
    assert texts(array) == [0.0, "y", "x", "z"]
    array[1] *= 2.0
    assert texts(array) == [0.0, "y", "x * 2.0", "z * 2.0"]


def test_a_plain_assignment_ends_provenance(xyz: Any) -> None:
    array = ANP.array(xyz)
    array[0] = 1.5  # the value that is there
    assert texts(array) == [1.5, "y", "z"]
    array[:] = 0.0
    assert arrays.elements(array) is None


def test_results_do_not_follow_their_operands(xyz: Any) -> None:
    array = ANP.array(xyz)
    factor = np.array([1.0, 2.0, 3.0])
    result = array * factor
    array[0] = 9.0
    factor[:] = 0.0
    assert texts(result) == ["x * 1.0", "y * 2.0", "z * 3.0"]
    assert evaluate(arrays.elements(result)[1], {SOURCES["y"]: 10.0}) == 20.0


def test_copies_keep_provenance_pickles_are_plain(xyz: Any) -> None:
    array = ANP.array(xyz)
    for made in (array.copy(), copy.copy(array), copy.deepcopy(array), ANP.array(array)):
        assert texts(made) == ["x", "y", "z"] and made is not array
        made[0] = 0.0
    assert texts(array) == ["x", "y", "z"]
    assert texts(ANP.asarray(array)) == ["x", "y", "z"]
    loaded = pickle.loads(pickle.dumps(array))
    assert type(loaded) is np.ndarray and same(loaded, array)
    assert pickle.dumps(array) == pickle.dumps(np.array([1.5, 2.5, -0.5]))


def test_it_passes_for_an_ndarray(xyz: Any) -> None:
    array = ANP.array(xyz)
    assert type(array) == np.ndarray and isinstance(array, np.ndarray)  # noqa: E721
    assert array.__class__ is np.ndarray
    assert str(array) == "[ 1.5  2.5 -0.5]" and repr(array) == "array([ 1.5,  2.5, -0.5])"
    assert not hasattr(array, "__dict__")
    assert dir(array) == dir(np.zeros(1))


def test_lists_of_elements(xyz: Any) -> None:
    array = ANP.array([xyz, xyz])
    assert array.tolist()[1][0] is xyz[0]
    assert [text(element) for element in array[0]] == ["x", "y", "z"]
    assert array.item(2) is xyz[2] and array.item((1, 1)) is xyz[1]


def test_errors_are_plain(xyz: Any) -> None:
    array = ANP.array(xyz)
    for wrong in (
        lambda a: a + np.ones(2), lambda a: a @ np.ones((2, 2)), lambda a: a[7], lambda a: a["x"],
        lambda a: a.reshape(2, 2), lambda a: np.concatenate([a, np.ones((1, 1))]),
        lambda a: a.sum(axis=3),
    ):  # fmt: skip
        with pytest.raises(Exception) as plain_error:
            wrong(np.array([1.5, 2.5, -0.5]))
        with pytest.raises(Exception) as error:
            wrong(array)
        assert type(error.value) is type(plain_error.value)
        assert str(error.value) == str(plain_error.value)


def test_warnings_are_plain() -> None:
    array = ANP.array([tracked("x")])
    with pytest.warns(RuntimeWarning, match="divide by zero"):
        found = array / 0.0
    assert found.tolist() == [math.inf]


def test_other_shapes_of_values(xyz: Any) -> None:
    assert texts(ANP.array(xyz, dtype=np.float32)) == ["x", "y", "z"]
    assert texts(ANP.array(xyz, dtype=int)) == ["int(x)", "int(y)", "int(z)"]
    assert texts(ANP.array(tuple(xyz))) == ["x", "y", "z"]
    assert texts(ANP.array(xyz[0])) == ["x"]
    count = leaf(Source("/n", "count", "int"), 3)
    assert texts(ANP.array([count, 1.5])) == ["float(count)", 1.5]
    assert ANP.array([count, 2]).dtype == np.array([3, 2]).dtype
    assert texts(ANP.array([count, 2]) * 2) == ["count * 2", 4]


def test_a_long_history_stays_short() -> None:
    """A filter over arrays; see `array_rules.MAX_DEPTH`."""
    gain, state = tracked("k") / 20.0, ANP.zeros(3)
    plain, plain_gain = np.zeros(3), VALUES["k"] / 20.0
    for step in range(500):
        measured = np.array([1.0, step, -step])
        state = gain * measured + (1.0 - gain) * state
        plain = plain_gain * measured + (1.0 - plain_gain) * plain
    assert same(state, plain)
    found = arrays.elements(state)
    assert all(is_tracked(element) and element._depth < 200 for element in found[1:])
    assert provenance(found[1]).sources == [SOURCES["k"]]


def test_refreshed_elements(xyz: Any) -> None:
    array = ANP.array(xyz) * 2
    new = leaf(SOURCES["x"], 10.0)

    def replace(element: Any) -> Any:
        return new if text(element).startswith("x") else element

    assert arrays.replace_elements(array, replace)
    assert array.tolist() == [10.0, 5.0, -1.0]
    assert texts(array) == ["x", "y * 2", "z * 2"]
    assert not arrays.replace_elements(array, lambda element: element)


def test_fields_of_messages_can_be_given_elements(xyz: Any) -> None:
    plain = np.array([1.5, 0.0, 2.5], dtype=np.float32)
    array = arrays.with_elements(plain, [xyz[0], 0.0, xyz[1]])
    assert np.shares_memory(array, plain) and array.dtype == np.float32
    assert texts(array) == ["x", 0.0, "y"]
    field = arrays.trackable(np.zeros(36))
    field[7] = tracked("k")
    assert texts(field)[7] == "k"


def test_uninstalling_and_installing_again() -> None:
    arrays.uninstall()
    try:
        assert not is_tracked(np.float64(2.0) * tracked("k"))
        assert not arrays.ADVICE
    finally:
        arrays.install()
        arrays.install()
    assert is_tracked(np.float64(2.0) * tracked("k"))


def test_names_of_functions_are_known_without_numpy() -> None:
    named = {**vars(np.linalg), **vars(np)}
    advised = {name for name, thing in named.items() if id(thing) in arrays.ADVICE}
    assert advised <= CALLS
    assert {"array", "zeros", "sin", "dot", "norm", "concatenate"} <= advised


def test_all_functions_can_be_hidden_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Functions between the program and numpy are given to the decorator, each once."""
    monkeypatch.setattr(arrays, "_hidden", {})  # whatever other tests have hidden
    seen: list[Any] = []
    for _ in range(2):
        arrays.install(hide=seen.append)
    assert len(seen) == len(set(map(id, seen)))
    names = {function.__name__ for function in seen}
    assert {"call_ufunc", "call_function", "__getitem__", "_array_ufunc", "operate"} <= names
    assert "_in_operator" not in names and "_number_array_ufunc" not in names


def test_methods_are_called_what_they_are_called(xyz: Any) -> None:
    """Programs that wrap arrays look at that: Pint does."""
    array = np.asarray(xyz)
    plain = np.asarray([untracked(one) for one in xyz])
    for name in set(dir(plain)) - {"T", "mT"}:
        for method, other in [(array, plain), (array[0], plain[0])]:
            if callable(getattr(other, name, None)) and name[:8] not in ("__array_", "__class_"):
                assert getattr(method, name).__name__ == getattr(other, name).__name__
