"""Random programs: what is recorded of them is what they do."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from hypothesis import assume, given
from hypothesis import strategies as st

from rosslt_auto.provenance import NotInvertible, is_tracked, provenance, untracked
from rosslt_auto.provenance.expressions import evaluate, gradient, leaves
from rosslt_auto.provenance.inversion import alternatives, invert, reached, rounding
from rosslt_auto.provenance.locations import source_of
from rosslt_auto.provenance.operators import OPERATORS
from support.tracked import bits, tracked

INFIX = {"add": "+", "sub": "-", "mul": "*", "truediv": "/"}
ROUGH = {"floordiv": "//", "mod": "%"}
SMOOTH = ["sin", "cos", "tanh", "atan", "asinh", "degrees", "float"]


class Instruction(NamedTuple):
    """An operator, and which earlier results (counted from the end) are its operands."""

    name: str
    operands: tuple[int, ...]


class Program(NamedTuple):
    """Instructions over numbered inputs; every result may be used again: a shared graph."""

    instructions: list[Instruction]

    def run(self, inputs: list[Any]) -> Any:
        """What it computes: with plain inputs plain Python, with tracked ones tracked values."""
        from rosslt_auto.provenance.values import record

        results = list(inputs)
        for name, operands in self.instructions:
            values = [results[-1 - (o % len(results))] for o in operands]
            plain = OPERATORS[name].forward(*map(untracked, values))
            if name in INFIX or name in ROUGH or name == "neg":
                results.append(OPERATORS[name].forward(*values))  # the overloaded operator
                assert bits(untracked(results[-1])) == bits(plain)
            else:
                results.append(record(OPERATORS[name], plain, *values))
        return results[-1]


def programs(names: list[str], longest: int = 12) -> st.SearchStrategy[Program]:
    def instruction(name: str) -> st.SearchStrategy[Instruction]:
        arity = 2 if name in INFIX or name in ROUGH else 1
        choice = st.integers(0, 9)
        return st.builds(Instruction, st.just(name), st.tuples(*[choice] * arity))

    one = st.sampled_from(names).flatmap(instruction)
    return st.builds(Program, st.lists(one, min_size=1, max_size=longest))


smooth = programs([*INFIX, "neg", *SMOOTH])
EVERYTHING = [*INFIX, *ROUGH, "neg", "abs", "floor", "round", "int", *SMOOTH]
any_program = programs(EVERYTHING)
inputs_ = st.lists(
    st.one_of(st.integers(-9, 9), st.floats(-9, 9, allow_subnormal=False)), min_size=1, max_size=4
)


def run_both(program: Program, plain: list[Any]) -> tuple[Any, Any, list[Any]]:
    """The plain result, the tracked one, and the tracked inputs."""
    try:
        expected = program.run(plain)
    except (ArithmeticError, ValueError):
        assume(False)
    inputs = [tracked(value, f"s{i}") for i, value in enumerate(plain)]
    return expected, program.run(inputs), inputs


@given(any_program, inputs_)
def test_values_and_evaluation(program: Program, plain: list[Any]) -> None:
    expected, value, _ = run_both(program, plain)
    assert type(untracked(value)) is type(expected)
    assert bits(untracked(value)) == bits(expected)
    if is_tracked(value):
        assert bits(evaluate(value, {})) == bits(expected)
        present = {source_of(leaf): leaf._v for leaf in leaves(value)}
        assert bits(evaluate(value, present)) == bits(expected)


@given(any_program, inputs_, st.data())
def test_evaluation_with_changes(program: Program, plain: list[Any], data: Any) -> None:
    """It is the program with other inputs, which never has to be run again."""
    _, value, inputs = run_both(program, plain)
    changed = [data.draw(st.integers(-9, 9) if type(v) is int else st.floats(-9, 9)) for v in plain]
    try:
        expected = program.run(changed)
    except (ArithmeticError, ValueError):
        assume(False)
    changes = {source_of(leaf): new for leaf, new in zip(inputs, changed, strict=True)}
    assert bits(evaluate(value, changes)) == bits(expected)
    if is_tracked(value):
        by_name = {source.parameter: changes[source] for source in provenance(value).sources}
        assert bits(provenance(value).evaluate(by_name)) == bits(expected)


@given(smooth, inputs_)
def test_gradient(program: Program, plain: list[Any]) -> None:
    """Equal to finite differences, taken where the program is tame."""
    plain = [float(value) for value in plain]
    expected, value, inputs = run_both(program, plain)
    assume(math.isfinite(expected) and abs(expected) < 1e6)
    slopes = gradient(value) if is_tracked(value) else {}
    for index, leaf in enumerate(inputs):
        slope = slopes.get(source_of(leaf), 0.0)
        found = difference(program, plain, index)
        if found is not None:
            assert math.isclose(slope, found, rel_tol=1e-4, abs_tol=1e-5)


def difference(program: Program, inputs: list[Any], index: int) -> float | None:
    """The slope by differences, None where they do not settle."""

    def shifted(by: float) -> float:
        return program.run([v + by if i == index else v for i, v in enumerate(inputs)])

    found = []
    try:
        for step in (1e-4, 5e-5, 2e-5):
            found.append((shifted(step) - shifted(-step)) / (2 * step))
    except (ArithmeticError, ValueError):
        return None
    settled = max(found) - min(found) <= 1e-6 * max(1.0, abs(found[0]))
    return found[-1] if settled and math.isfinite(found[0]) else None


@given(smooth, inputs_, st.data())
def test_what_is_reachable_is_reached(program: Program, plain: list[Any], data: Any) -> None:
    """A value that the program has with another value of one source that occurs once.

    Where slopes are extreme, floats near the solution may all miss the target: left out.
    """
    plain = [float(value) for value in plain]
    _, value, inputs = run_both(program, plain)
    assume(is_tracked(value))
    slopes = gradient(value)
    present = [leaf for leaf in inputs if 1e-3 < abs(slopes.get(source_of(leaf), 0.0)) < 1e3]
    assume(present)
    leaf = data.draw(st.sampled_from(present))
    other = leaf._v + data.draw(st.floats(-0.5, 0.5))
    try:
        target = evaluate(value, {source_of(leaf): other})
        near = gradient(value, {source_of(leaf): other})[source_of(leaf)]
    except (ArithmeticError, ValueError, KeyError):
        assume(False)
    assume(type(target) is float and math.isfinite(target) and 1e-3 < abs(near) < 1e3)
    solution = invert(value, target, source=source_of(leaf).parameter)
    assert solution.exact
    assert set(solution.changes) <= {source_of(leaf)}
    assert reached(evaluate(value, solution.changes), target, finest=rounding(value))
    assert reached(solution.value, target, finest=rounding(value))


@given(programs(EVERYTHING, 6), inputs_, st.floats(-20, 20))
def test_every_answer_is_true(program: Program, plain: list[Any], target: float) -> None:
    """Whatever `invert` answers is what the program then computes; a refusal has a reason."""
    _, value, inputs = run_both(program, plain)
    assume(is_tracked(value))
    wanted: Any = target if type(value) == float else round(target)  # noqa: E721
    for policy in ("left", "least-change"):
        try:
            solution = invert(value, wanted, policy)
        except NotInvertible as refusal:
            assert str(refusal)
            continue
        changed = [solution.changes.get(source_of(leaf), leaf._v) for leaf in inputs]
        assert all(type(a) is type(b) for a, b in zip(changed, plain, strict=True))
        try:
            assert bits(program.run(changed)) == bits(solution.value)
        except ArithmeticError:  # in an instruction that the value does not depend on
            assert bits(evaluate(value, solution.changes)) == bits(solution.value)
        if solution.exact:
            assert reached(solution.value, wanted, finest=rounding(value))
        else:
            assert abs(solution.value - wanted) < abs(untracked(value) - wanted)


@given(smooth, inputs_, st.floats(-20, 20))
def test_alternatives(program: Program, plain: list[Any], target: float) -> None:
    """Each source alone: solved, or refused with a reason, left bias first."""
    _, value, _ = run_both(program, [float(v) for v in plain])
    assume(is_tracked(value) and type(untracked(value)) is float)
    found = alternatives(value, target)
    assert [source for source, _ in found] == provenance(value).sources
    for source, answer in found:
        if isinstance(answer, NotInvertible):
            assert str(answer)
        else:
            assert set(answer.changes) <= {source}
            now = evaluate(value, answer.changes)
            assert reached(now, target, finest=rounding(value))
