"""What a user can do wrong, without any node; and programs that `run` runs as python would."""

import sys
import textwrap
from pathlib import Path

import pytest

from support.domains import reserved_domain
from support.process import Outcome, Program, environment, finish, rosslt_auto, start

VERBS = ["run", "echo", "force", "locations", "save"]


@pytest.mark.parametrize("verb", VERBS)
def test_help(verb: str, own_domain: int) -> None:
    outcome = rosslt_auto(verb, "--help", domain=own_domain)
    assert outcome.status == 0
    assert verb in outcome.stdout
    assert outcome.stderr == ""


def test_help_names_the_verbs(own_domain: int) -> None:
    outcome = rosslt_auto("--help", domain=own_domain)
    assert outcome.status == 0
    assert all(verb in outcome.stdout for verb in VERBS)


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["nosuch"],
        ["run"],
        ["run", "--nosuch", "x.py"],
        ["echo"],
        ["echo", "/foo", "--timeout", "soon"],
        ["force", "/foo"],
        ["force", "/foo", "data"],
        ["force", "/foo", "=1"],
        ["force", "/foo", "data=1", "--policy", "right"],
    ],
    ids=" ".join,
)
def test_wrong_usage(arguments: list[str], own_domain: int) -> None:
    outcome = rosslt_auto(*arguments, domain=own_domain)
    assert outcome.status == 2, outcome
    assert outcome.stdout == ""
    assert outcome.stderr
    assert "Traceback" not in outcome.stderr


@pytest.mark.parametrize("arguments", [["echo", "/nosuch", "--once"], ["force", "/nosuch", "x=1"]])
def test_unknown_topic(arguments: list[str], own_domain: int) -> None:
    outcome = rosslt_auto(*arguments, "--timeout", "1", domain=own_domain)
    outcome.assert_clean_failure(1, says="/nosuch")
    assert outcome.stdout == ""


@pytest.mark.parametrize("arguments", [["echo", "no such", "--once"], ["force", "//x", "x=1"]])
def test_topic_that_cannot_be_a_name(arguments: list[str], own_domain: int) -> None:
    outcome = rosslt_auto(*arguments, "--timeout", "1", domain=own_domain)
    outcome.assert_clean_failure(1, 2, says=arguments[1])


def test_locations_without_nodes(own_domain: int) -> None:
    outcome = rosslt_auto("locations", "--json", domain=own_domain)
    assert outcome.status == 0
    assert outcome.json_lines in ([], [[]])


def test_script_that_does_not_exist(own_domain: int) -> None:
    rosslt_auto("run", "nosuch.py", domain=own_domain).assert_clean_failure(says="nosuch.py")
    rosslt_auto("run", "-m", "nosuch", domain=own_domain).assert_clean_failure(says="nosuch")


PROGRAMS = {
    "arguments": """
        import sys, os
        print(sys.argv[1:], os.path.basename(sys.argv[0]), sys.path[0] == os.path.dirname(__file__))
        print(__name__, __file__ == os.path.abspath(__file__), __spec__, __package__, __doc__)
        print(sorted(name for name in globals() if not name.startswith("__")))
        print(sorted(globals())[:9], dir() == sorted(globals()))
    """,
    "exit status": "import sys; sys.exit(3)",
    "exit message": "import sys; sys.exit('gone')",
    "syntax error": "x = 1\ny = = 2\n",
    "indentation error": "def f():\nreturn 1\n",
    "null byte": "x = 1\0\n",
    "exception": """
        def scale(value, factor=2.0):
            return value * factor / (value - 1.5)


        print(scale(0.5))
        print(scale(3.0 * 0.5))
    """,
    "exception in an operator": "total = 0.5\nfor part in (1.5, 'x'):\n    total = total + part\n",
    "recursion": """
        def deeper(n):
            return 1 + deeper(n + 1)


        try:
            deeper(0)
        except RecursionError as error:
            print(type(error))
    """,
    "numbers": """
        import json, math, pickle, copy, struct, decimal, fractions
        from enum import IntEnum

        class Level(IntEnum):
            LOW = 1
            HIGH = 2

        values = [0.5, -1.5, 2, 10**20, 1e300, -0.0, 7 // 2, 7 % 3, 2 ** 0.5, 1 << 70, ~5]
        print(values, [type(value).__name__ for value in values], [hash(value) for value in values])
        print(json.dumps(values), [copy.deepcopy(value) for value in values])
        print(pickle.loads(pickle.dumps(values)) == values, struct.pack("<dq", 1.5, 3).hex())
        print(f"{0.1 + 0.2:.3f} {1.5!r:>8} {255:#x} {1e6:,}", "%5.2f|%d" % (2.5, 7), str(1e16))
        print(sum([0.1] * 10), math.fsum([0.1] * 10), max(1, 1.0), round(2.5), round(2.675, 2))
        print(float("1.5") is float("1.5"), int(7.9), float(3), abs(-2.5))
        print(divmod(7.5, 2), pow(2, 5, 7), -7 // 2, 7.5 % -2, +3, 1_000.5)
        print(decimal.Decimal(0.5) + 1, fractions.Fraction(0.5), complex(1.0, 2), 1.5 + 2j)
        print(isinstance(0.5, float), isinstance(True, int), type(0.5) is float, 3 in range(5))
        print([1, 2, 3][1], "ab" * 2, [0] * 3, (1.0).is_integer(), (5).bit_length(), Level(2).name)
        match 2:
            case 1 | 2:
                print("matched")
        print({1: "a", 1.0: "b"}, 0.1 + 0.2 == 0.3, 1 < 1.5 <= 2, not 0.0, bool(0.5))
    """,
    "parts": "def f(a, b=2, *, c=3.5):\n    'doc'\n    return a\nprint(f.__defaults__,"
    " f.__kwdefaults__, f.__doc__, f.__code__.co_firstlineno, f.__code__.co_varnames)\n",
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_program_runs_as_python_runs_it(name: str, tmp_path: Path) -> None:
    script = tmp_path / "program.py"
    script.write_text(textwrap.dedent(PROGRAMS[name]))
    plain, instrumented = (outcome(script, instrumented) for instrumented in (False, True))
    assert instrumented == plain
    assert plain.stdout or plain.stderr or plain.status


def outcome(script: Path, instrumented: bool) -> Outcome:
    with reserved_domain() as domain:
        arguments = ("-p", "--verbose", "a b")
        return finish(start(script, *arguments, domain=domain, instrumented=instrumented))


def test_program_without_ros_in_reach(tmp_path: Path) -> None:
    """`run` of a plain program needs no rclpy; a node says itself that it is missing."""
    hidden = tmp_path / "hidden"
    (hidden / "rclpy").mkdir(parents=True)
    (hidden / "rclpy" / "__init__.py").write_text(
        "raise ModuleNotFoundError(\"No module named 'rclpy'\", name='rclpy')\n"
    )
    script = tmp_path / "program.py"
    script.write_text("print(1.5 + 2)\n")
    variables = {"PYTHONPATH": f"{hidden}:{environment(1).get('PYTHONPATH', '')}"}
    program = start(script, domain=1, instrumented=True, **variables)
    assert finish(program) == Outcome(0, "3.5\n", "")

    command = [sys.executable, "-m", "rosslt_auto", "echo", "/foo", "--once"]
    missing = finish(Program(command, environment(1, **variables)))
    assert missing.status == 1
    assert "Traceback" not in missing.stderr
    # Both ways to get it.
    assert "rosslt_auto[ros]" in missing.stderr
    assert "setup.bash" in missing.stderr or "source" in missing.stderr
