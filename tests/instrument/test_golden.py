"""What the rewriter makes of small files, as `run --show-rewritten` prints it.

After a change of the rewriter that is meant: ``pytest tests/instrument/test_golden.py
--update-golden``, and look at the difference.
"""

from pathlib import Path

import pytest

from rosslt_auto.instrument.showing import rewritten_source

FOLDER = Path(__file__).parent / "golden"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.stem)
def test_rewritten(path: Path, request: pytest.FixtureRequest) -> None:
    found = rewritten_source(path.stem, path.name, path.read_bytes())
    expected = path.with_suffix(".txt")
    if request.config.getoption("--update-golden"):
        expected.write_text(found)
    assert found == expected.read_text()
