"""The fast part: a few programs of each kind, and that the harness finds what there is to find."""

from __future__ import annotations

import sys
from pathlib import Path
from textwrap import dedent

import pytest

from transparency import comparing, reporting, running
from transparency.__main__ import chosen, patterns
from transparency.comparing import PROGRAM, compare
from transparency.suites import SUITES, Case, Expected, cases

FAST = [
    "programs:uncaught exception", "programs:asyncio", "programs:json.tool",
    "numbers:test_complex", "numbers:test_format", "library:test_colorsys", "library:test_shlex",
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("title", FAST)
def test_nobody_can_tell(title: str) -> None:
    found = [case for case in cases(title.partition(":")[0]) if case.title == title]
    if not found and title.startswith("library"):
        pytest.skip("this Python came without its tests")
    result = compare(found[0])
    assert result.tests
    assert not result.failed, "\n".join(reporting.lines(result, details=True))


def test_every_table_can_be_read() -> None:
    for suite in SUITES:
        names = [case.name for case in cases(suite)]
        assert len(names) == len(set(names))
        assert all(case.modules for case in cases(suite))


@pytest.mark.parametrize(
    ("words", "suites"),
    [
        ([], {"programs", "numbers", "packages"}), (["numbers:*"], {"numbers"}),
        (["all"], {"programs", "numbers", "packages", "extensions", "library"}),
    ],
)  # fmt: skip
def test_suites_are_chosen(words: list[str], suites: set[str]) -> None:
    there = {suite for suite in suites if list(cases(suite))}  # this Python may have no tests
    assert {case.suite for case in chosen(patterns(words))} == there


def test_one_program_is_chosen() -> None:
    assert [case.title for case in chosen(["packages:utm"])] == ["packages:utm"]


# ---------------------------------------------------------------- it finds differences

SUBJECT = """
    import under_comparison as subject
    import unittest

    class T(unittest.TestCase):
        def test_same(self):
            self.assertEqual(subject.half, 0.5)

        def test_type(self):
            self.assertIs(type(subject.half), float)

        def test_failing_the_same_way(self):
            subject.fail()

        def test_parts(self):
            for n in (1, 2):
                with self.subTest(n=n):
                    self.assertIs(type(subject.half), float)
"""


@pytest.fixture
def case(tmp_path: Path) -> Case:
    """Test modules that can tell, as they compare types themselves."""
    (tmp_path / "under_comparison.py").write_text("half = 0.5\ndef fail(): return 1 / (half - 0.5)")
    (tmp_path / "test_under_comparison.py").write_text(dedent(SUBJECT))
    return Case(
        "made", "up", "record_unittest", ["test_under_comparison"], ["under_comparison"],
        path=[tmp_path],
    )  # fmt: skip


TYPE = "test_under_comparison.T.test_type"
PARTS = "test_under_comparison.T.test_parts*"


@pytest.mark.slow
def test_differences_are_found(case: Case) -> None:
    result = compare(case, tries=1)
    assert result.tests == 4
    assert TYPE in {difference.test for difference in result.surprises}
    assert all("test_type" in d.test or "test_parts" in d.test for d in result.surprises)
    assert result.failed


@pytest.mark.slow
def test_expected_differences_have_a_reason_and_must_be_there(case: Case) -> None:
    case.expected = [Expected(TYPE, "seen"), Expected(PARTS, "seen twice")]
    result = compare(case)
    assert not result.failed
    assert {difference.reason for difference in result.expected} == {"seen", "seen twice"}
    case.expected.append(Expected("*.test_same", "imagined"))
    case.expected.append(Expected("*.test_same", "found elsewhere", always=False))
    result = compare(case, tries=1)
    assert [expected.reason for expected in result.vanished] == ["imagined"]
    assert result.failed


def _outcome(**what: object) -> running.Outcome:
    finding = {"what": "error", "raised": [
        {"type": "builtins.KeyError", "message": "1", "notes": [], "frames": [["f.py", "f", 3, 4]]},
    ]}  # fmt: skip
    outcome = running.Outcome({"t": [finding], "": [{"what": "end"}]}, 0, ("out\n", ""))
    for name, value in what.items():
        if name == "status":
            outcome.status = value  # type: ignore[assignment]
        elif name == "output":
            outcome.output = value  # type: ignore[assignment]
        else:
            finding["raised"][0][name] = value  # type: ignore[index]
    return outcome


@pytest.mark.parametrize(
    ("changed", "test"),
    [
        ({"type": "builtins.IndexError"}, "t"), ({"message": "2"}, "t"), ({"notes": ["n"]}, "t"),
        ({"frames": [["f.py", "f", 3, 5]]}, "t"), ({"frames": []}, "t"), ({"status": 1}, PROGRAM),
        ({"status": None}, PROGRAM), ({"output": ("out", "")}, f"{PROGRAM} stdout"),
        ({"output": ("out\n", "warning")}, f"{PROGRAM} stderr"),
    ],
)  # fmt: skip
def test_what_counts_as_a_difference(changed: dict, test: str) -> None:
    assert list(comparing.differences(_outcome(), _outcome())) == []
    [found] = comparing.differences(_outcome(), _outcome(**changed))
    assert found.test == test
    assert found.plain != found.instrumented


# ---------------------------------------------------------------- caches


@pytest.mark.slow
def test_cold_and_warm_caches_give_the_same(tmp_path: Path) -> None:
    """Three runs with one folder for bytecode: nothing in it, only plain code, all of it."""
    document = Path(__file__).parent / "data" / "values.json"
    case = Case(
        "made", "up", "", ["-m", "json.tool", str(document)], ["json", "json.*"],
        variables={"PYTHONPYCACHEPREFIX": str(tmp_path)},
    )  # fmt: skip
    cold = running.run(case, True)
    assert cold.status == 0
    assert "12345678901234567890" in cold.output[0]
    assert list(tmp_path.rglob("decoder*.rosslt-*.pyc"))
    warm, plain = running.run(case, True), running.run(case, False)
    assert (cold.status, cold.output) == (warm.status, warm.output) == (plain.status, plain.output)


def test_the_report_lists_programs_and_reasons(tmp_path: Path) -> None:
    document = tmp_path / "report.md"
    other = "### The ROS 2 examples and demos (Python 3.99.1)\n\nkept\n"
    document.write_text(f"By hand.\n\n{reporting.MARK}\nold\n\n{other}")
    small = comparing.Difference("t", "a", "b", "small integers are not the same objects")
    packages = comparing.Result(Case("packages", "utm"), note="not fetched: offline")
    for _ in range(2):
        reporting.write(document, [comparing.Result(Case("numbers", "test_int"), 44), packages])
        reporting.write(document, [comparing.Result(Case("numbers", "test_int"), 45, [small])])
    text = document.read_text()
    assert text.startswith("By hand.\n")
    assert "old" not in text
    assert "| test_int | 45 | 1 | small integers are not the same objects |" in text
    assert "| utm |  |  | not fetched: offline |" in text
    assert text.count("(Python {}.{}.{})".format(*sys.version_info)) == 2
    assert text.endswith(other)
