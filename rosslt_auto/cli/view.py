"""``view``: a page in the browser with drag handles inferred from provenance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from . import Failure, need_ros, options, say

NO_VISER = 'the browser page needs viser: install it with `pip install "rosslt_auto[view]"`'


def main(words: Sequence[str]) -> int:
    """Serves the page until interrupted."""
    parser = options.parser("view", "Shows messages in the browser, with drag handles.")
    parser.add_argument("topics", metavar="TOPIC", nargs="*", help="show only these")
    add_page_options(parser)
    arguments = parser.parse_args(words)
    need_ros()
    need_viser()

    from rosslt_auto.ros.observer import CannotObserve, Observer
    from rosslt_auto.views.browser import CannotServe, Page
    from rosslt_auto.views.frames import Frames
    from rosslt_auto.views.session import Session

    with Observer("view") as observer:
        try:
            with (
                Session(observer, arguments.topics, saver(observer), Frames()) as session,
                Page(session, arguments.host, arguments.port) as page,
            ):
                print(page.address, flush=True)
                say("press Ctrl-C to end")
                page.run()
        except (CannotObserve, CannotServe) as reason:
            raise Failure(str(reason)) from None
    return 0


def add_page_options(parser: Any) -> None:
    """``--host`` and ``--port``"""
    parser.add_argument("--host", default="127.0.0.1", help="listen there (default: 127.0.0.1)")
    parser.add_argument(
        "--port", type=port, metavar="P", help="listen on this port (default: a free one)"
    )


def port(text: str) -> int:
    """A number of a port."""
    import argparse

    try:
        number = int(text)
    except ValueError:
        number = 0
    if not 0 < number < 65536:
        raise argparse.ArgumentTypeError(f"{text!r} is no port")
    return number


def need_viser() -> None:
    """Raises Failure where viser cannot be imported."""
    try:
        import viser  # noqa: F401
    except ImportError:
        raise Failure(NO_VISER) from None


def saver(observer: Any) -> Any:
    """What writes changes into files."""
    from rosslt_auto.ros.saving import ViewSaver

    return ViewSaver(observer)
