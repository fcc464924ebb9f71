"""What differs between a plain and an instrumented run, and whether that was expected."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

from transparency.packages import NotFetched
from transparency.running import Outcome, run
from transparency.suites import Case, Expected

_PLACE = re.compile(r" from '[^']*'")
"""Where a module is on this machine, in the text of an error."""


@dataclass(frozen=True)
class Difference:
    """A test with another outcome: what it is in words, without and with instrumentation."""

    test: str
    plain: str
    instrumented: str
    reason: str | None = None


@dataclass
class Result:
    """Of one case.

    tests      how many were compared
    expected   differences with their reason
    surprises  differences without
    vanished   expected differences that were not found: as wrong as a surprise
    note       why there is nothing to compare, or ""
    """

    case: Case
    tests: int = 0
    expected: list[Difference] = field(default_factory=list)
    surprises: list[Difference] = field(default_factory=list)
    vanished: list[Expected] = field(default_factory=list)
    note: str = ""
    seconds: tuple[float, float] = (0.0, 0.0)

    @property
    def failed(self) -> bool:
        return bool(self.surprises or self.vanished)


PROGRAM = "(the program)"
"""Stands for a test's name where the exit status or what was printed differs."""


def compare(case: Case, tries: int = 3) -> Result:
    """Runs a case both ways; differences count if they are there each time.

    Some tests differ between any two runs, as they look at times, addresses or the network.
    Therefore a difference is looked for again, against other runs, before it is reported.
    """
    if case.prepare is not None:
        try:
            case.prepare()
        except NotFetched as error:
            return Result(case, note=f"not fetched: {error}")
    plain = run(case, False)
    result = Result(case, _count(plain) if case.recorder else 1, seconds=(plain.seconds, 0.0))
    if plain.status is None:
        result.note = f"takes more than {case.timeout:g} s"
        result.tests = 0
    elif not result.tests:
        why = (plain.output[1].strip().splitlines() or ["none"])[-1]
        result.note = f"no tests here: {_PLACE.sub('', why)}"
    if result.note:
        return result
    instrumented = run(case, True)
    result.seconds = plain.seconds, instrumented.seconds
    found = {difference.test: difference for difference in differences(plain, instrumented)}
    others = [plain]
    for _ in range(tries - 1):
        if set(found) <= {test for test in found if _reason(case, test)}:
            break
        others.append(run(case, False))
        instrumented = run(case, True)
        again = [{d.test for d in differences(other, instrumented)} for other in others]
        unstable = {d.test for other in others[:-1] for d in differences(other, others[-1])}
        found = {
            test: difference
            for test, difference in found.items()
            if test not in unstable and all(test in tests for tests in again)
        }
    _judge(case, result, found)
    return result


def _judge(case: Case, result: Result, found: dict[str, Difference]) -> None:
    for test, difference in found.items():
        reason = _reason(case, test)
        if reason is None:
            result.surprises.append(difference)
        else:
            result.expected.append(
                Difference(test, difference.plain, difference.instrumented, reason)
            )
    for expected in case.expected:
        there = any(fnmatchcase(test, expected.test) for test in found)
        if expected.always and not there:
            result.vanished.append(expected)


def _reason(case: Case, test: str) -> str | None:
    for expected in case.expected:
        if fnmatchcase(test, expected.test):
            return expected.reason
    return None


def _count(outcome: Outcome) -> int:
    return sum(
        any(finding["what"] != "in a part" for finding in found)
        for test, found in outcome.findings.items()
        if test
    )


def differences(plain: Outcome, instrumented: Outcome) -> Iterator[Difference]:
    """All differences between two runs, test by test."""
    for test in dict.fromkeys([*plain.findings, *instrumented.findings]):
        one, other = plain.findings.get(test), instrumented.findings.get(test)
        if one != other and test:
            yield Difference(test, *_where(one, other))
    if (plain.status, plain.findings.get("")) != (
        instrumented.status,
        instrumented.findings.get(""),
    ):
        yield Difference(PROGRAM, _end(plain), _end(instrumented))
    else:
        for name, one_text, other_text in zip(
            ("stdout", "stderr"), plain.output, instrumented.output, strict=True
        ):
            if one_text != other_text:
                yield Difference(f"{PROGRAM} {name}", *_lines(one_text, other_text))


def _end(outcome: Outcome) -> str:
    last = (outcome.output[1].strip().splitlines() or [""])[-1]
    end = outcome.findings.get("", [{"reason": "it did not come to its end"}])[0].get("reason", "")
    status = "stopped after its time" if outcome.status is None else f"status {outcome.status}"
    return f"{status}, {end} {last}".strip()


def _lines(one: str, other: str) -> tuple[str, str]:
    """The first lines that differ."""
    ours, theirs = one.splitlines(), other.splitlines()
    for a, b in zip([*ours, "(end)"], [*theirs, "(end)"], strict=False):
        if a != b:
            return a, b
    return (one[-80:], other[-80:])


def _where(one: list[dict] | None, other: list[dict] | None) -> tuple[str, str]:
    """The first finding that differs, in words."""
    for a, b in zip([*(one or []), None], [*(other or []), None], strict=False):
        if a != b:
            first, second = _words(a), _words(b)
            if first == second and a and b:
                return _frames(a, b)
            return first, second
    return "(nothing)", "(nothing)"


def _words(finding: dict | None) -> str:
    if finding is None:
        return "(not run)"
    errors = finding.get("raised") or []
    text = " <- ".join(f"{e['type'].removeprefix('builtins.')}: {e['message']}" for e in errors)
    return f"{finding['what']} {text}{finding.get('reason', '')}".strip()


def _frames(one: dict, other: dict) -> tuple[str, str]:
    for a, b in zip(one.get("raised", []), other.get("raised", []), strict=False):
        for mine, theirs in zip([*a["frames"], None], [*b["frames"], None], strict=False):
            if mine != theirs:
                return f"frame {mine}", f"frame {theirs}"
    return str(one), str(other)
