"""The code panel: HTML of source files with the literals that matter and their values now."""

from __future__ import annotations

import html
import os
from collections.abc import Collection, Sequence
from typing import Any

from .listing import Listing, Literal, Marked, SourceFile

_WHOLE = 60
_AROUND = 2
"""Files of so many lines are shown whole; of longer ones this many lines around each literal."""

STYLE = """<style>
.rosslt { font: 12px/1.5 ui-monospace, Menlo, Consolas, monospace; color: #24292f; }
.rosslt .file { font-weight: 600; margin: 8px 0 2px; overflow-wrap: anywhere; }
.rosslt pre { margin: 0; padding: 6px 0; background: #f6f8fa; border-radius: 6px; overflow-x: auto;
  font: inherit; }
.rosslt .line { display: block; padding: 0 8px; white-space: pre; }
.rosslt .no { color: #8c959f; display: inline-block; width: 3ch; margin-right: 1ch;
  text-align: right; user-select: none; }
.rosslt .gap { color: #8c959f; padding-left: 8px; display: block; }
.rosslt mark { background: #dbeafe; color: inherit; border-radius: 3px; padding: 0 2px; }
.rosslt mark.changed { background: #fde68a; font-weight: 600; }
.rosslt mark.given { background: #e9d5ff; font-weight: 600; }
.rosslt mark.live { background: #f97316; color: #fff; }
.rosslt s { color: #8c959f; margin-right: 2px; }
.rosslt .error { background: #fee2e2; }
.rosslt .reason { color: #b91c1c; display: block; padding: 0 8px 0 5ch; white-space: pre-wrap; }
.rosslt table { border-collapse: collapse; width: 100%; font: inherit; }
.rosslt td { vertical-align: top; padding: 1px 6px 1px 0; overflow-wrap: anywhere; }
.rosslt td:nth-child(-n+3) { white-space: nowrap; }
.rosslt .dim { color: #6e7781; }
.rosslt .will { color: #c2410c; font-weight: 600; }
</style>"""


def number(value: Any) -> str:
    """A value, not longer than people read while they drag."""
    return f"{value:.6g}" if isinstance(value, float) and len(repr(value)) > 9 else repr(value)


def code(listing: Listing, live: Collection[tuple[str, str]] = ()) -> str:
    """All files. `live`: node and parameter of what is being dragged."""
    files = listing.files()
    if not files:
        return _page("<p class=dim>No literal has reached a message yet.</p>")
    return _page("".join(_file(one, live) for one in files))


def _page(content: str) -> str:
    return f"{STYLE}<div class=rosslt>{content}</div>"


def _file(file: SourceFile, live: Collection[tuple[str, str]]) -> str:
    name = os.path.relpath(file.path)
    name = name if len(name) < len(file.path) else file.path
    heading = f'<div class=file title="{html.escape(file.path)}">{html.escape(name)}</div>'
    if file.lines is None:
        shown = sorted(file.marked)
    elif len(file.lines) <= _WHOLE:
        shown = list(range(1, len(file.lines) + 1))
    else:
        near = {n + d for n in [*file.marked, *file.errors] for d in range(-_AROUND, _AROUND + 1)}
        shown = sorted(n for n in near if 1 <= n <= len(file.lines))
    rows = []
    before = shown[0] - 1 if shown else 0
    for n in shown:
        if n != before + 1:
            rows.append("<span class=gap>⋮</span>")
        before = n
        rows.append(_line(file, n, live))
    return heading + f"<pre>{''.join(rows)}</pre>"


def _line(file: SourceFile, n: int, live: Collection[tuple[str, str]]) -> str:
    marked = file.marked.get(n, [])
    text = file.lines[n - 1] if file.lines is not None else marked[0].literal.text
    parts = []
    at = 0
    for one in marked:
        if one.start < at:
            continue
        parts.append(html.escape(text[at : one.start]))
        parts.append(_mark(one, text, live))
        at = max(at, one.end)
    parts.append(html.escape(text[at:]))
    error = file.errors.get(n)
    kind = "line error" if error else "line"
    reason = f"<span class=reason>{html.escape(error)}</span>" if error else ""
    return f'<span class="{kind}"><span class=no>{n}</span>{"".join(parts)}</span>{reason}'


def _mark(one: Marked, text: str, live: Collection[tuple[str, str]]) -> str:
    literal = one.literal
    written = html.escape(text[one.start : one.end])
    title = f"{literal.parameter} of {literal.node}"
    if literal.given is not None:
        title += f", {literal.given}"
    title = html.escape(title, quote=True)
    is_live = (literal.node, literal.parameter) in live
    if not (literal.differs or is_live):
        return f'<mark title="{title}">{written}</mark>'
    kind = "live" if is_live else "changed" if literal.changed else "given"
    now = html.escape(number(literal.value))
    return f'<s>{written}</s><mark class="{kind}" title="{title}">{now}</mark>'


def origin(title: str, rows: Sequence[tuple[str, Any, str, Sequence[tuple[Literal, bool]]]]) -> str:
    """Where the fields of a handle come from.

    rows  for each field: its path, value and expression, its sources, and which will be changed
    """
    parts = [f"<div class=file>{html.escape(title)}</div>"]
    for path, value, expression, literals in rows:
        said = "" if expression == repr(value) else f"= {html.escape(expression)}"
        parts.append(
            f"<div><b>{html.escape(path)}</b> = {html.escape(number(value))}"
            f" <span class=dim>{said}</span></div><table>"
        )
        for literal, will_change in literals:
            kind = "will" if will_change else "dim"
            place = ""
            if literal.file is not None:
                place = f"{os.path.basename(literal.file)}:{literal.line}"
            parts.append(
                f"<tr class={kind}><td>{'→' if will_change else ''}</td>"
                f"<td>{html.escape(number(literal.value))}</td>"
                f"<td>{html.escape(place)}</td>"
                f"<td>{html.escape(literal.text or literal.parameter)}<br>"
                f"<span class=dim>{html.escape(_lives(literal))}</span></td></tr>"
            )
        parts.append("</table>")
    return _page("".join(parts))


def _lives(literal: Literal) -> str:
    """Whose it is, and where its value lives if that is not where the literal stands."""
    if literal.given is not None:
        return f"{literal.node}, {literal.given}"
    if literal.in_data:
        return f"{literal.node}, in a file that follows every change"
    return literal.node
