"""Join point: how pytest loads test modules, plugins and conftest files (its assertion rewriting).

Selected ones get both rewritings. Ours comes first and leaves ``assert`` statements alone, so that
pytest explains a failure as it always does; its cache is neither read nor written. pytest is not
imported here for a program that does without.
"""

from __future__ import annotations

import ast
import sys
from pathlib import Path
from types import CodeType
from typing import Any

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints, around
from . import tables
from .errors import NotParsed

_MODULE = "_pytest.assertion.rewrite"

_points = JoinPoints()


def install() -> None:
    """Wraps pytest's loader as soon as pytest is imported. Idempotent."""
    if not _points:
        method = "AssertionRewritingHook.exec_module"
        _points.replace_when_imported(_MODULE, method, around(_exec_module))


def uninstall() -> None:
    """The loader is as it was, save where somebody else has wrapped it since."""
    _points.restore()


@unseen
def _exec_module(wrapped: Any, loader: Any, args: Any, kwargs: Any) -> Any:
    code = _advice(loader, *args, **kwargs)
    if code is None:
        return wrapped(*args, **kwargs)
    exec(code, vars(args[0] if args else kwargs["module"]))
    return None


def _advice(loader: Any, module: Any) -> CodeType | None:
    """Instrumented code, or None if the plain function is to be called. Raises nothing."""
    from . import hook  # which has this as one of its ways

    name, path = module.__name__, getattr(module.__spec__, "origin", None)
    if path is None or not hook.selects(name, path):
        return None
    try:
        code = _instrumented(name, path, loader.config)
        loader._rewritten_names[name] = Path(path)  # what pytest's own function notes
    except NotParsed:
        return None
    except Exception as error:
        hook.say_once(name, path, error)
        return None
    hook.loaded.add((name, path))
    return code


def _instrumented(name: str, path: str, config: Any) -> CodeType:
    from .weaving import entry_of, rewritten_tree

    pytest: Any = sys.modules[_MODULE]
    with open(path, "rb") as file:
        source = file.read()
    tree, table, rewritten = rewritten_tree(name, path, source, leave=(ast.Assert,))
    pytest.rewrite_asserts(tree, source, path, config)
    code = compile(tree, path, "exec", dont_inherit=True)
    tables.publish(entry_of(name, path, table, code, rewritten), source)
    return code
