"""`run` with whole programs, from the command line."""

import subprocess
import sys
from pathlib import Path

from support.process import rosslt_auto


def test_patterns_in_vain_are_said_at_the_end(tmp_path: Path) -> None:
    (tmp_path / "helper.py").write_text("x = 0.5")
    script = tmp_path / "program.py"
    script.write_text("import helper\nprint(helper.x)\nraise SystemExit(3)\n")
    found = rosslt_auto("run", "--module", "help*", "--module", "hlep*", str(script), domain=0)
    assert (found.status, found.stdout) == (3, "0.5\n")
    said = "rosslt_auto: --module hlep*: the program has imported no such module\n"
    assert found.stderr == said


def test_many_patterns_in_vain_are_one_line(tmp_path: Path) -> None:
    script = tmp_path / "program.py"
    script.write_text("x = 0.5\n")
    words = [word for number in range(9) for word in ("--module", f"m{number}")]
    found = rosslt_auto("run", *words, str(script), domain=0)
    assert found.stderr == (
        "rosslt_auto: --module m0, m1, m2, m3, m4 and 4 more: "
        "the program has imported no such module\n"
    )


SLOW = {"asyncio", "dataclasses", "importlib.metadata", "inspect", "logging", "numpy", "wrapt"}


def test_nothing_slow_is_imported_for_a_program_that_does_without(tmp_path: Path) -> None:
    script = tmp_path / "program.py"
    script.write_text(f"import sys\nx = 0.5\nprint(sorted({SLOW} & set(sys.modules)))\n")
    plain = subprocess.run([sys.executable, script], capture_output=True, text=True)
    ours = rosslt_auto("run", str(script), domain=0)
    assert (ours.status, ours.stdout, ours.stderr) == (0, plain.stdout, "")
