"""Texts of programs, some of which only later versions of Python can compile."""

import sys
from typing import Any

import pytest

Since = dict[str, tuple[tuple[int, int], str]]
"""By name: the version that a text needs, and the text."""


def cases(texts: dict[str, str], since: Since) -> list[Any]:
    """Parameters for a test of each text; skipped where the version is too old for it."""
    return [
        *(pytest.param(text, id=name) for name, text in texts.items()),
        *(
            pytest.param(
                text,
                id=name,
                marks=pytest.mark.skipif(
                    sys.version_info < version,
                    reason=f"syntax of Python {'.'.join(map(str, version))}",
                ),
            )
            for name, (version, text) in since.items()
        ),
    ]
