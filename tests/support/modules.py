"""Modules and packages written for a test."""

import re
import textwrap
from pathlib import Path


def write_modules(folder: Path, files: dict[str, str], before: str = "") -> None:
    """Writes source files.

    files   texts by name: ``a__b`` is ``a/b.py``, ``a____init__`` is ``a/__init__.py``
    before  what each of them begins with
    """
    for name, text in files.items():
        name = re.sub(r"//(\w+)/$", r"/__\1__", name.replace("__", "/"))
        path = folder / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(before + textwrap.dedent(text))
