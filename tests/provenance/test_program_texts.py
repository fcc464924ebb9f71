"""Random programs as source texts: they do what plain Python does, and what is recorded of them
is what they would do with other literals."""

from __future__ import annotations

import functools
import math
from types import CodeType
from typing import Any

from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from rosslt_auto.instrument import hook
from rosslt_auto.provenance import is_tracked, provenance, untracked
from rosslt_auto.provenance.expressions import evaluate, gradient, leaves, topological
from rosslt_auto.provenance.inversion import invert, reached, rounding
from rosslt_auto.provenance.locations import Location, source_of
from support.program_texts import program_texts
from support.tracked import bits

FILE = "program.py"


class Run:
    """What a program leaves.

    values  floats, ints and texts by where they are: `f0`, `v0[2]`, `table['k']`
    shown   what the program shows of each
    trace   what it has decided
    error   type, message and positions of what ended it
    """

    def __init__(self, code: CodeType) -> None:
        names: dict[str, Any] = {"__name__": "program"}
        self.error = None
        try:
            exec(code, names)
        except Exception as error:
            self.error = (type(error), str(error), _positions(error))
        self.trace = names["trace"]
        self.values: dict[str, Any] = {}
        for name, value in names.items():
            if name[:1] != "_" and name != "trace":
                self._add(name, value)
        self.shown = {path: _shown(value) for path, value in self.values.items()}

    def _add(self, path: str, value: Any) -> None:
        if isinstance(value, (list, dict)):
            for key, item in value.items() if isinstance(value, dict) else enumerate(value):
                self._add(f"{path}[{key!r}]", item)
        elif isinstance(value, (float, int, str)):
            self.values[path] = value

    def tracked(self) -> dict[str, Any]:
        """The tracked values, each once."""
        found = {id(value): (path, value) for path, value in self.values.items()}
        return {path: value for path, value in found.values() if is_tracked(value)}


def _positions(error: Exception) -> list[Any]:
    found, trace = [], error.__traceback__
    while trace is not None:
        code = trace.tb_frame.f_code
        if code.co_filename == FILE:
            found.append(list(code.co_positions())[trace.tb_lasti // 2])
        trace = trace.tb_next
    return found


def _shown(value: Any) -> Any:
    return value.__class__.__name__, repr(value), bits(untracked(value))


def plain(text: str) -> Run:
    return Run(compile(text, FILE, "exec", dont_inherit=True))


@functools.lru_cache(maxsize=1)
def instrumented(text: str) -> Run:
    return Run(hook.instrumented_code("program", FILE, text.encode(), cached=False))


def with_literal(text: str, location: Location, value: Any) -> str:
    """The text with another value in the place of a literal."""
    lines, info = text.split("\n"), location.info
    line = lines[info.line - 1]
    lines[info.line - 1] = f"{line[: info.column]}({value!r}){line[info.end_column :]}"
    return "\n".join(lines)


def other_value(draw: Any, value: Any) -> Any:
    """Another value of the same kind, not far away."""
    if type(value) is str:
        return draw(st.sampled_from(["q", "zz ", "a", "/b", "1.5"]))
    if type(value) is int:
        return value + draw(st.sampled_from([-2, -1, 1, 2, 5]))
    return value + draw(st.floats(-0.5, 0.5))


def a_source(draw: Any, values: dict[str, Any]) -> Location:
    found = {source: None for value in values.values() for source in provenance(value).sources}
    assume(found)
    return draw(st.sampled_from(sorted(found, key=lambda source: source.parameter)))


def is_smooth(value: Any) -> bool:
    """Whether it is computed without steps, which count as if they were ramps, and texts."""
    nodes = topological([value])
    return not any(type(untracked(node)) is str or node._op.name in STEPS for node in nodes)


STEPS = frozenset({"round", "floor", "ceil", "trunc", "int", "floordiv", "mod"})

more = settings(
    max_examples=2 * settings.default.max_examples,
    phases=[Phase.explicit, Phase.generate],  # to make such a program shorter takes minutes
)


@more
@given(program_texts(ending=True))
def test_as_plain_and_evaluated_again(text: str) -> None:
    """Values bit for bit, decisions, and the error with its message and its positions."""
    expected, found = plain(text), instrumented(text)
    assert found.error == expected.error
    assert found.trace == expected.trace
    assert found.shown == expected.shown
    for value in found.tracked().values():
        present = {source_of(leaf): leaf._v for leaf in leaves(value)}
        for changes in ({}, present):
            again = evaluate(value, changes)
            assert type(again) is type(untracked(value))
            assert bits(again) == bits(untracked(value))


@more
@given(program_texts(), st.data())
def test_evaluation_is_the_program_with_another_literal(text: str, data: Any) -> None:
    """Wherever that decides the same: nothing else has to be run again to know its values."""
    found = instrumented(text)
    assume(found.error is None)
    source = a_source(data.draw, found.tracked())
    new = other_value(data.draw, source.value)
    expected = plain(with_literal(text, source, new))
    assume(expected.error is None and expected.trace == found.trace)
    for path in found.values.keys() & expected.values.keys():  # keys of a dict are values, too
        value = found.values[path]
        now = evaluate(value, {source: new}) if is_tracked(value) else value
        assert type(now) is type(expected.values[path])
        assert bits(now) == bits(expected.values[path]), path


@more
@given(program_texts(), st.data())
def test_a_reachable_value_is_reached(text: str, data: Any) -> None:
    """One that the program has with another value of the source, where slopes are not extreme."""
    values = {path: value for path, value in instrumented(text).tracked().items()
              if type(untracked(value)) is float}  # fmt: skip
    assume(values)
    value = values[data.draw(st.sampled_from(sorted(values)))]
    source = a_source(data.draw, {"": value})
    assume(source.kind == "float")
    new = other_value(data.draw, source.value)
    try:
        target = evaluate(value, {source: new})
        slopes = [gradient(value, {source: at}).get(source, 0.0) for at in (source.value, new)]
    except (ArithmeticError, ValueError):
        assume(False)
    assume(target != value and math.isfinite(target))
    assume(all(1e-3 < abs(slope) < 1e3 for slope in slopes))
    solution = invert(value, target, source=source.parameter)
    assert solution.exact and set(solution.changes) <= {source}
    assert reached(evaluate(value, solution.changes), target, finest=rounding(value))
    for policy in ("left", "least-change"):
        assert reached(invert(value, target, policy).value, target, finest=rounding(value))


@more
@given(program_texts(), st.data())
def test_slopes_are_those_of_differences(text: str, data: Any) -> None:
    """Of the program itself, with literals that differ a little; where it is tame."""
    found = instrumented(text)
    source = a_source(data.draw, found.tracked())
    assume(found.error is None and source.kind == "float")
    steps = (1e-4, 5e-5, 2e-5)
    runs = [[plain(with_literal(text, source, source.value + sign * step)) for sign in (1, -1)]
            for step in steps]  # fmt: skip
    assume(all(run.error is None and run.trace == found.trace for pair in runs for run in pair))
    for path, value in found.tracked().items():
        if type(untracked(value)) is float and abs(value) < 1e6 and is_smooth(value):
            differences = [(up.values[path] - down.values[path]) / (2 * step)
                           for step, (up, down) in zip(steps, runs, strict=True)]  # fmt: skip
            if max(differences) - min(differences) <= 1e-6 * max(1.0, abs(differences[0])):
                slope = gradient(value).get(source, 0.0)
                assert math.isclose(slope, differences[-1], rel_tol=1e-4, abs_tol=1e-5), path
