"""Tracking from within a program: `tracked_module`, `install`, `uninstall`.

What ``python -m rosslt_auto run`` does from outside. This is where instrumenting code and weaving
rclpy come together; neither knows of the other, and neither needs ROS to be there.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable
from sys import _getframe
from typing import TypeVar

from .instrument import hook, live, subinterpreters, tables
from .instrument.selection import Selection
from .provenance import bindings, untracked
from .ros import weave

T = TypeVar("T")


def tracked_module(thing: T) -> T:
    """Decorator for a class or a function, or a call with a module that is already imported.

    Its code, and what is nested in it, is instrumented in place: the same object is returned, a
    class keeps its identity, a function its closure, and both are pickled as before. Literals that
    plain code has evaluated already - default arguments, attributes of the class, globals of the
    module - are replaced by locations where they are still what the source says. What was computed
    from them, and objects made before, stay plain; so do base classes and submodules.

    Values reach ROS messages as under ``python -m rosslt_auto run``, from nodes that are made
    later. Applied again, or to code that is instrumented already, it does nothing.

    Code whose source cannot be found, or is not what was loaded, is instrumented as well; what it
    has evaluated already stays plain. Raises TypeError for anything but a class, a function or a
    module.
    """
    if subinterpreters.refuses():
        return thing
    _weave_ros()
    live.instrument(thing, _getframe(1).f_code.co_filename)
    return thing


def install(modules: Iterable[str] = (), exclude: Iterable[str] = ()) -> None:
    """Instruments modules from their next import on, and weaves rclpy. Idempotent.

    modules, exclude  patterns of dotted names as for ``run --module`` and ``--exclude``
    """
    if subinterpreters.refuses():
        return
    _weave_ros()
    hook.install(Selection(patterns=modules, excludes=exclude))


def uninstall() -> None:
    """Makes the program plain again: its imports, functions, names and rclpy. Idempotent.

    What is running ends as it began, and what it needs stays until the next call of this function.
    """
    weave.uninstall()
    live.restore()
    hook.uninstall()
    bindings.replace_everywhere(untracked)
    tables.withdraw()


def _weave_ros() -> None:
    if not weave.is_prepared():
        weave.prepare(sys.argv[1:])
