"""pytest under `run`: the same report, with tests, fixtures and nodes tracked."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from support.modules import write_modules

NODE = """
GAIN = 0.5
def compute(x): return x * 2.0 + GAIN
"""
CONFTEST = """
import pytest
OFFSET = 1.5
@pytest.fixture
def offset():
    return OFFSET * 2.0
"""
TESTS = '''
"""Doc of the tests."""
from __future__ import annotations
import pytest
from node import compute
from tests.support.seen import note
LIMIT = 7.0
def test_passing(offset):
    note("conftest", offset); note("node", compute(1.5)); note("test", LIMIT)
    assert compute(offset) == 6.5
@pytest.mark.parametrize("x", [0.5, 1.5])
def test_compared(x):
    y = compute(x)
    assert y == x + LIMIT, f"got {y}"
def test_called():
    assert round(compute(float("1.0")) * 2) in range(3)
def test_containers():
    assert {"a": [1.0, 2.0]} == {"a": [1.0, compute(2.0)]}
def test_approximate():
    assert compute(0.1) == pytest.approx(0.7000001)
    assert compute(0.1) == pytest.approx(0.8) and not compute(0.5)
def test_raises():
    with pytest.raises(ZeroDivisionError, match="division"):
        compute(1.0) / (LIMIT - 7.0)
    compute(1.0) / (LIMIT - 7.0)
'''


@pytest.mark.slow
def test_pytest_under_run(both, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    write_modules(tmp_path, {"node": NODE, "conftest": CONFTEST, "test_node": TESTS})
    options = ("--module", "node", "--module", "conftest", "--module", "test_*")
    words = ("-m", "pytest", "-q", "-p", "no:cacheprovider", "test_node.py")
    for _ in range(2):  # pytest keeps what it has rewritten: neither may find the other's
        plain, ours = (
            replace(one, stdout=re.sub(r"in [\d.]+s", "in 0s", one.stdout))
            for one in both(*words, options=options)
        )
        assert "6 failed, 1 passed" in plain.stdout, plain
        assert ours == plain
    tracked = {path.stem for path in tmp_path.glob("*.tracked")}
    assert tracked == {"conftest", "node", "test"}
