"""Lets calls of numpy and of module `array` keep provenance, once the program imports these.

Neither is imported here for a program that does without.
"""

from __future__ import annotations

import sys

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints
from . import calls

_points = JoinPoints()


def install() -> None:
    """Weaves numpy and `array` as soon as they are there. Idempotent."""
    if not _points:
        _points.when_imported("numpy", _weave_numpy)
        _points.when_imported("array", _weave_array)


def uninstall() -> None:
    """Calls are plain again; arrays that have provenance keep it."""
    _points.restore()
    arrays = sys.modules.get("rosslt_auto.provenance.arrays")
    if arrays is not None:
        calls.forget(arrays.ADVICE)
        arrays.uninstall()
    sequences = sys.modules.get("rosslt_auto.provenance.sequences")
    if sequences is not None:
        calls.forget(sequences.ADVICE)


def _weave_numpy() -> None:
    try:
        from ..provenance import arrays

        arrays.install(hide=unseen)
        calls.learn(arrays.ADVICE)
        calls.DISGUISED[type(arrays.TrackedArray)] = arrays.TrackedArray.__mro__[1]
    except Exception as error:  # another numpy than the ones we know
        import logging

        logging.getLogger(__name__).warning(
            "no provenance in numpy, it is not as expected: %r", error
        )


def _weave_array() -> None:
    from ..provenance import sequences

    calls.learn(sequences.ADVICE)
    calls.DISGUISED[type(sequences.TrackedBuffer)] = sequences.TrackedBuffer.__mro__[1]
