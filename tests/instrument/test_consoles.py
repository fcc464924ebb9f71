"""Consoles and notebooks: what is typed is tracked, and shows what it shows plain."""

import code
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosslt_auto.instrument import hook
from rosslt_auto.instrument.selection import Selection
from rosslt_auto.provenance import provenance


def _sources(value: Any) -> list[str]:
    found = provenance(value)
    return [] if found is None else [source.parameter for source in found.sources]


TYPED = """\
x = 0.5
y = x * 2.5
def f(a):
    return a + 1.5

y; f(2.0)
1 / 0
def g(): return 1 +
print(sorted(globals()))
"""


def test_consoles(packages: Callable[..., Path], capsys: pytest.CaptureFixture[str]) -> None:
    def typed(console: code.InteractiveConsole) -> str:
        for line in TYPED.splitlines():
            console.push(line)
        captured = capsys.readouterr()
        return captured.out + captured.err

    plain_console = code.InteractiveConsole({})
    hook.uninstall()
    plain = typed(plain_console)
    packages()
    hook.install(Selection())
    console = code.InteractiveConsole({})
    assert typed(console) == plain
    assert "ZeroDivisionError" in plain and "SyntaxError" in plain
    assert _sources(plain_console.locals["f"](2.0)) == []
    value = console.locals["f"](console.locals["y"])
    assert set(_sources(value)) == {
        "rosslt.console.in_1.x", "rosslt.console.in_2.y", "rosslt.console.in_3.f.f",
    }  # fmt: skip
    hook.uninstall()
    assert "runcode" not in vars(code.InteractiveConsole)
    assert code.InteractiveInterpreter.runcode.__code__.co_filename == code.__file__


AT_PROMPT = """\
import rosslt_auto, sys
from helper import OFFSET
x = 0.5
y = x * 2.5
y
def f(a):
    return a + OFFSET

f(y), sorted(globals()), sys.argv, sys.path[0]
1 / 0
[source.parameter for source in getattr(rosslt_auto.provenance(f(y)), "sources", ())]
exit(3)
"""


def test_prompt(both: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("OFFSET = 1.5\n")
    plain, ours = both("-i", python=("-q",), options=(), input=AT_PROMPT)
    assert plain.status == ours.status == 3
    assert plain.stdout.endswith("[]\n") and "ZeroDivisionError" in plain.stderr
    *shown, sources = re.sub("^(>>> |[.][.][.] )+", "", ours.stdout, flags=re.M).splitlines()
    assert shown == plain.stdout.splitlines()[:-1]
    assert set(eval(sources)) == {
        "rosslt.console.in_3.x", "rosslt.console.in_4.y", "rosslt.helper.OFFSET",
    }  # fmt: skip


NOTEBOOK = """
import os, sys
os.environ["IPYTHONDIR"] = os.getcwd()
from IPython.core.interactiveshell import InteractiveShell
from traitlets.config import Config
import rosslt_auto

shell = InteractiveShell(config=Config(HistoryManager={"enabled": False}), colors="nocolor")
for cell in (
    "x = 1.5\\ny = 2.0 * x\\nx = 3.0",
    "import asyncio\\ndef f(a):\\n    return a * 4.0\\nz = f(x)\\nz",
    "await asyncio.sleep(0)\\nw = 7.0",
    "1 / (x - x)",
    "def g(): return 1 +",
    "sorted(set(globals()) - {'_dh', '_oh'})",
    "%time w",
    "f'{x:.2f}'",
):
    shell.run_cell(cell, store_history=True)
names = shell.user_ns
found = [rosslt_auto.provenance(names[name]) for name in "xyzw"]
print()
print([one and [source.parameter for source in one.sources] for one in found])
print([one and [(source.line, source.text) for source in one.sources] for one in found])
"""


def test_notebooks(both, tmp_path: Path) -> None:
    """Cells as a kernel executes them: each statement by itself, with ``await`` and magic."""
    program = tmp_path / "notebook.py"
    program.write_text(NOTEBOOK)
    plain, ours = both(str(program), options=())
    *shown, names, places = ours.stdout.splitlines()
    timed = ("CPU times", "Wall time")
    assert [line for line in shown if not line.startswith(timed)] == [
        line for line in plain.stdout.splitlines()[:-2] if not line.startswith(timed)
    ]
    assert ours.stderr == plain.stderr
    assert plain.stdout.splitlines()[-1] == "[None, None, None, None]"
    assert eval(names) == [
        ["rosslt.console.in_1_3.x"],
        ["rosslt.console.in_1.x", "rosslt.console.in_1_2.y"],
        ["rosslt.console.in_1_3.x", "rosslt.console.in_2_2.f.f"],
        ["rosslt.console.in_3_2.w"],
    ]
    assert eval(places) == [
        [(3, "x = 3.0")],
        [(1, "x = 1.5"), (2, "y = 2.0 * x")],
        [(3, "x = 3.0"), (3, "return a * 4.0")],
        [(2, "w = 7.0")],
    ]
