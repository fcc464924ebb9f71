"""Source texts as instrumented modules of the test process."""

import itertools
import sys
import textwrap
import types
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rosslt_auto.instrument import hook
from rosslt_auto.provenance import refresh
from rosslt_auto.provenance.registry import count_executions, location_of

_numbers = itertools.count()


class Instrumented:
    """A loaded module; its names are attributes of `names`."""

    def __init__(self, names: Any) -> None:
        self.names = names

    def location(self, name: str) -> Any:
        """The location with this parameter name, below the module's."""
        found = location_of(f"rosslt.{self.names.__name__}.{name}")
        assert found is not None, name
        return found

    def change(self, name: str, value: Any) -> None:
        """A request that changes a literal."""
        refresh.apply({self.location(name): value})


@contextmanager
def loaded(source: str, folder: Path) -> Iterator[Instrumented]:
    """A source text, loaded as an instrumented module under a new name."""
    module = types.ModuleType(f"loaded_{next(_numbers)}")
    path = folder / f"{module.__name__}.py"
    text = textwrap.dedent(source)
    path.write_text(text)
    code = hook.instrumented_code(module.__name__, str(path), text.encode(), cached=False)
    count_executions()  # as if a node had been made
    sys.modules[module.__name__] = module
    try:
        exec(code, module.__dict__)
        yield Instrumented(module)
    finally:
        del sys.modules[module.__name__]
