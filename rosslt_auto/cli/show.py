"""What the verbs print: provenance as JSON and as text."""

from __future__ import annotations

import json
import os
import sys
from typing import TYPE_CHECKING, Any

from rosslt_auto.provenance.expressions import source_values, sources
from rosslt_auto.provenance.sources import Source
from rosslt_auto.provenance.texts import text
from rosslt_auto.provenance.values import untracked

if TYPE_CHECKING:
    from rich.console import Console


def field_to_json(value: Any) -> dict[str, Any]:
    """A tracked value as in contract.md, JSON of `echo`."""
    return {
        "value": untracked(value),
        "expression": text(value),
        "sources": [source_to_json(source, now) for source, now in sources_with_values(value)],
    }


def sources_with_values(value: Any) -> list[tuple[Source, Any]]:
    """The sources of a tracked value and their values, the one that left bias prefers first."""
    now = source_values(value)
    return [(source, now[source]) for source in sources(value)]


def source_to_json(source: Source, value: Any) -> dict[str, Any]:
    """A source of a value; what its remark says where it has one."""
    remark: dict[str, Any] = {"frozen": True} if source.frozen else {}
    if source.limits is not None:
        remark["range"] = list(source.limits)
    return {
        "node": source.node,
        "parameter": source.parameter,
        "file": source.file,
        "line": source.line,
        "column": source.column,
        "value": value,
        **remark,
    }


def print_json(document: Any) -> None:
    """One document on one line, at once. NaN and infinities are null: JSON has none."""
    try:
        line = json.dumps(document, ensure_ascii=False, allow_nan=False)
    except ValueError:
        line = json.dumps(_finite(document), ensure_ascii=False)
    print(line, flush=True)


def _finite(document: Any) -> Any:
    if isinstance(document, dict):
        return {key: _finite(value) for key, value in document.items()}
    if isinstance(document, list):
        return [_finite(value) for value in document]
    if isinstance(document, float) and not (float("-inf") < document < float("inf")):
        return None
    return document


def console() -> Console:
    """Where text for people goes. Lines are not broken: they may be searched and copied."""
    from rich.console import Console

    return Console(highlight=False, markup=False, emoji=False, soft_wrap=True, file=sys.stdout)


def place(file: str | None, line: int | None, column: int | None) -> str:
    """``file:line:column``, the file relative to here where that is shorter."""
    if file is None:
        return ""
    near = os.path.relpath(file)
    return f"{near if len(near) < len(file) else file}:{line}:{column}"
