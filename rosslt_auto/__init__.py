"""Provenance for ROS 2 nodes written in Python, without changing them.

``python -m rosslt_auto run node.py`` runs a node so that every number it publishes knows the
literal or parameter that it came from; this module is what programs may use of it themselves.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from .provenance import provenance as provenance
    from .provenance import untracked as untracked
    from .provenance.external import create_location as create_location
    from .ros.operations import force_value as force_value
    from .ros.operations import reevaluate as reevaluate
    from .tracking import install as install
    from .tracking import tracked_module as tracked_module
    from .tracking import uninstall as uninstall

_WHERE = {
    "create_location": ".provenance.external",
    "force_value": ".ros.operations",
    "reevaluate": ".ros.operations",
    "provenance": ".provenance",  # the package itself, which can be called
    "untracked": ".provenance",
    "tracked_module": ".tracking",
    "install": ".tracking",
    "uninstall": ".tracking",
}
"""Where each public name lives; importing this package alone loads nothing else."""

__all__ = sorted(_WHERE)


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(_WHERE[name], __name__)
    value = module if name == "provenance" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
