"""Functions of the standard library that refuse subclasses, called with tracked values."""

from __future__ import annotations

import _socket
import io
import marshal
import socket
import sys
from collections.abc import Callable, Iterator
from textwrap import dedent
from typing import Any

import pytest

from rosslt_auto.instrument import exact_types
from rosslt_auto.provenance import Source
from rosslt_auto.provenance.values import leaf


def tracked(value: Any) -> Any:
    return leaf(Source("/node", "x", type(value).__name__), value)


@pytest.fixture(autouse=True)
def woven() -> Iterator[None]:
    exact_types.install()
    exact_types.install()
    yield
    exact_types.uninstall()
    exact_types.uninstall()


def test_a_port_number_is_an_address() -> None:
    plain = socket.getaddrinfo("127.0.0.1", 5000, type=socket.SOCK_STREAM)
    assert socket.getaddrinfo(tracked("127.0.0.1"), tracked(5000), type=socket.SOCK_STREAM) == plain
    assert _socket.getaddrinfo(host=None, port=tracked(80)) == _socket.getaddrinfo(None, 80)


@pytest.mark.parametrize(
    "thing", [1.5, [1, "a"], ("x", (2, 3.0)), {"k": [4]}, {5}, frozenset({"b"}), None, b"c", True]
)
def test_marshalled_as_the_plain_thing(thing: Any) -> None:
    def track(one: Any) -> Any:
        if isinstance(one, dict):
            return {track(key): track(value) for key, value in one.items()}
        if isinstance(one, (list, tuple, set, frozenset)):
            return type(one)(map(track, one))
        return tracked(one) if type(one) in (int, float, str) else one

    loaded = marshal.loads(marshal.dumps(track(thing)))
    assert loaded == thing
    assert type(loaded) is type(thing)
    file = io.BytesIO()
    marshal.dump(track(thing), file)
    assert marshal.loads(file.getvalue()) == thing


def test_interned() -> None:
    assert sys.intern(tracked("some text")) is sys.intern("some text")
    assert type(sys.intern(tracked("some other text"))) is str


def test_code_of_a_file_with_a_tracked_name() -> None:
    code = compile("def f():\n  def g(): return 0.5", tracked("a.py"), "exec")
    plain = compile("def f():\n  def g(): return 0.5", "a.py", "exec")
    assert marshal.dumps(code, 1) == marshal.dumps(plain, 1)


def test_too_deep_is_for_the_function_to_say() -> None:
    thing: list = []
    for _ in range(100_000):
        thing = [thing]
    with pytest.raises(ValueError, match="too deeply nested"):
        marshal.dumps(thing)
    while thing:  # so that it is not freed in one go
        thing = thing[0]


def test_errors_are_the_functions_own() -> None:
    with pytest.raises(ValueError, match="unmarshallable") as raised:
        marshal.dumps(object())
    assert len(raised.traceback) == 1
    with pytest.raises(TypeError):
        _socket.getaddrinfo()


def test_uninstalled_as_before() -> None:
    exact_types.uninstall()
    assert type(marshal.dumps) is type(_socket.getaddrinfo) is type(len)


ASKING = {
    "xmlrpc": """
        from xmlrpc.client import dumps, loads
        result = loads(dumps((1, 2.5, "x", {"k": [3]}), "f"))
    """,
    "headers": """
        from wsgiref.headers import Headers
        headers = Headers([("Content-Type", "text/plain")])
        headers["X-Rate"] = "5"
        result = str(headers)
    """,
    "application": """
        import io
        from wsgiref.handlers import SimpleHandler
        from wsgiref.util import setup_testing_defaults
        from wsgiref.validate import validator
        def application(environ, start):
            start("200 OK", [("Content-Type", "text/plain")])
            return [b"done"]
        environ, out = {"QUERY_STRING": ""}, io.BytesIO()
        setup_testing_defaults(environ)
        SimpleHandler(io.BytesIO(), out, io.StringIO(), environ).run(validator(application))
        result = out.getvalue().splitlines()[0], out.getvalue().splitlines()[-1]
    """,
    "connection": """
        import tempfile, threading
        from multiprocessing.connection import Client, Listener
        with tempfile.TemporaryDirectory() as folder, Listener(f"{folder}/s") as listener:
            threading.Thread(target=lambda: Client(f"{folder}/s").send([0.5, "x"])).start()
            with listener.accept() as connection:
                result = connection.recv()
    """,
    "manager": """
        from multiprocessing.managers import SyncManager
        class Manager(SyncManager): pass
        Manager.register("Scan", list, exposed=("append",), method_to_typeid={"copy": "list"})
        result = sorted(Manager._registry["Scan"][2])
    """,
    "fork server": """
        import multiprocessing
        multiprocessing.get_context("forkserver").set_forkserver_preload(["json"])
        result = None
    """,
    "syntax tree": """
        import ast
        name, value = "x", 2.5
        tree = ast.parse("y = 1")
        tree.body[0].value = ast.BinOp(ast.Name(name, ast.Load()), ast.Add(), ast.Constant(value))
        tree.body.append(ast.Global(names=["z", name + "2"]))
        tree.body.append(ast.Expr(ast.Constant(("a", (1, 2)))))
        tree.body.extend(ast.parse("re = __import__('re').compile('b+')").body)
        made = {"x": 1}
        exec(compile(ast.fix_missing_locations(tree), "made.py", "exec"), made)
        result = made["y"], made["re"].pattern, compile("1 + 1", "made.py", mode="eval").co_consts
    """,
    "csv": """
        import csv
        limit = 200000
        before = csv.field_size_limit(limit)
        result = csv.field_size_limit(before)
    """,
    "asserted": """
        import unittest
        def said(first, second):
            try:
                unittest.TestCase().assertEqual(first, second)
            except AssertionError as error:
                return str(error)
        text = "one, two"
        result = said(text, "".join(["one"])), said(text.upper(), ""), said([1, 2.5], [1])
    """,
    "patched": """
        import math
        from unittest import mock
        with mock.patch.multiple("math", pi=3.0):
            result = math.pi
    """,
}


@pytest.mark.parametrize("program", ASKING)
def test_python_code_that_asks_for_types(
    instrumented: Callable[..., dict[str, Any]], program: str
) -> None:
    source = dedent(ASKING[program])
    plain: dict[str, Any] = {}
    exec(source, plain)
    assert instrumented(source)["result"] == plain["result"]
