"""`run --module PATTERN` where the pattern matches nothing."""

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
