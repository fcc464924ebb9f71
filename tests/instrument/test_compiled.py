"""Functions that numba compiles."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rosslt_auto.instrument import compiled
from rosslt_auto.provenance import is_tracked

NUMBA = """
class FunctionIdentity:
    @classmethod
    def from_function(cls, pyfunc):
        names = {name for code in codes(pyfunc.__code__) for name in code.co_names}
        return any(name.startswith("@") for name in names)

def codes(code):
    yield code
    for constant in code.co_consts:
        if hasattr(constant, "co_code"):
            yield from codes(constant)
"""


def test_numba_reads_plain_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, instrumented: Callable[..., dict[str, Any]]
) -> None:
    (tmp_path / "numba" / "core").mkdir(parents=True)
    (tmp_path / "numba" / "core" / "bytecode.py").write_text(NUMBA)
    monkeypatch.syspath_prepend(str(tmp_path))
    compiled.install()
    compiled.install()
    try:
        names = instrumented("""
            from numba.core.bytecode import FunctionIdentity
            reads = FunctionIdentity.from_function
            def njit(function): return reads(function), function
            @njit
            def outer(x, k=2.5):
                def inner(y): return y * 1.5
                return inner(x) + k
            found = njit(lambda x: x * 3.5)
            def other(): return 0.5
        """)
        assert names["outer"][0] is names["found"][0] is False
        assert names["outer"][1](2.0) == 5.5 and names["found"][1](2.0) == 7.0
        assert is_tracked(names["other"]())
    finally:
        compiled.uninstall()
        for name in [name for name in sys.modules if name.partition(".")[0] == "numba"]:
            del sys.modules[name]
