"""Values given for literals at start: ``-p rosslt.x:=v``, ``--params-file``, a launch file.

Read from the command line before the program starts, because a literal has to have its value
before its first use; what only rcl can decide - a section for a node whose name stands in the
code - follows when the node is made, see `parameters`. Needs no rclpy.

Rules: https://design.ros2.org/articles/ros_command_line_arguments.html
"""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rosslt_auto.provenance.registry import set_initial_values

PREFIX = "rosslt."

_given: dict[str, Any] = {}
_arguments: list[str] = []
_origins: dict[tuple[str, str | None], str | None] = {}


def prepare(arguments: Sequence[str]) -> None:
    """Sets aside what a program's command line says about literals that are loaded later."""
    if "--ros-args" not in arguments:
        return
    _arguments[:] = arguments
    _origins.clear()
    _given.update(read(arguments))
    if _given:
        set_initial_values(_given, refuse)


def is_given(name: str, value: Any) -> bool:
    """Whether the command line has already given this literal this value."""
    return name in _given and _given[name] == value and type(_given[name]) is type(value)


def origin(name: str, node: str | None) -> str | None:
    """What has given a literal of a node its value, if known: ``-p`` or a parameter file's path."""
    key = (name, node)
    if key not in _origins:
        found = [where for given, _, where in _items(_arguments, node) if given == name]
        _origins[key] = found[-1] if found else None
    return _origins[key]


def add(values: Mapping[str, Any]) -> None:
    """The same for what turned out later, for modules that are loaded later still."""
    _given.update(values)
    set_initial_values(values, refuse)


def refuse(reason: str) -> None:
    """Tells that a literal keeps its value."""
    print(f"rosslt_auto: {reason}", file=sys.stderr)


def read(arguments: Sequence[str]) -> dict[str, Any]:
    """The values by parameter name under ``rosslt.`` that apply to any node of the program.

    Files that cannot be read are passed over: rcl says so itself.
    """
    return {name: value for name, value, _ in _items(arguments)}


def _items(arguments: Sequence[str], node: str | None = None) -> Iterator[tuple[str, Any, str]]:
    """(name, value, where it is said) for a node, by default any; later ones take precedence."""
    options = list(_ros_options(arguments))
    node = node or _node_name(options)
    for option, value in options:
        if option == "-p":
            pattern, name, text = _split_rule(value)
            if name.startswith(PREFIX) and _matches(pattern, node):
                yield name, _scalar(text), "-p"
        elif option == "--params-file":
            for pattern, name, item in _file_values(value):
                if name.startswith(PREFIX) and _matches(pattern, node):
                    yield name, item, os.path.abspath(value)


_TWO_WORDS = {"-p": "-p", "--param": "-p", "--params-file": "--params-file"}
_REMAP = {"-r": "-r", "--remap": "-r"}


def _ros_options(arguments: Sequence[str]) -> Iterator[tuple[str, str]]:
    """(option, value) of parameters and remaps in the ``--ros-args`` parts of a command line."""
    words = iter(arguments)
    inside = False
    for word in words:
        if not inside:
            inside = word == "--ros-args"
        elif word == "--":
            inside = False
        elif (option := (_TWO_WORDS | _REMAP).get(word)) is not None:
            yield option, next(words, "")


def _split_rule(rule: str) -> tuple[str, str, str]:
    """``node:name:=value`` as (pattern of the node, name, value)."""
    left, _, value = rule.partition(":=")
    pattern, colon, name = left.rpartition(":")
    return (pattern if colon else "/**", name, value)


def _node_name(options: Sequence[tuple[str, str]]) -> str | None:
    """The full name that remaps give every node of the program, None if its code does."""
    name, namespace = None, "/"
    for option, rule in options:
        if option == "-r":
            left, _, value = rule.partition(":=")
            if left == "__node":
                name = value
            elif left == "__ns":
                namespace = value
    return f"{namespace.rstrip('/')}/{name}" if name else None


def _matches(pattern: str, node: str | None) -> bool:
    if pattern in ("/**", "**"):
        return True
    if node is None:
        return False
    tokens = [_token(token) for token in pattern.strip("/").split("/")]
    return re.fullmatch("".join(tokens), node) is not None


def _token(token: str) -> str:
    if token == "**":
        return "(?:/[^/]+)*"
    return "/" + re.escape(token).replace(r"\*", "[^/]*")


def _scalar(text: str) -> Any:
    import yaml  # comes with rclpy

    try:
        return _number(yaml.safe_load(text))
    except yaml.YAMLError:
        return text


_EXPONENT = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+")


def _number(value: Any) -> Any:
    """YAML 1.1 asks for a dot and a sign in ``1e3``; rcl does not."""
    if isinstance(value, str) and _EXPONENT.fullmatch(value):
        return float(value)
    return value


def _file_values(path: str) -> Iterator[tuple[str, str, Any]]:
    """(pattern of the node, name, value) from a parameter file."""
    import yaml

    try:
        with open(path, encoding="utf-8") as file:
            text = file.read()
        content = yaml.safe_load(text) if "rosslt" in text else None
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return
    yield from _sections(content, "")


def _sections(content: Any, pattern: str) -> Iterator[tuple[str, str, Any]]:
    if not isinstance(content, dict):
        return
    for key, below in content.items():
        if key == "ros__parameters":
            for name, value in _flat(below, ""):
                yield pattern, name, value
        else:
            yield from _sections(below, f"{pattern}/{str(key).strip('/')}")


def _flat(content: Any, prefix: str) -> Iterator[tuple[str, Any]]:
    if not isinstance(content, dict):
        return
    for key, value in content.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", _number(value)
