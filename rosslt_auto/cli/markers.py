"""``markers``: an interactive marker server for RViz, its handles inferred from provenance."""

from __future__ import annotations

import threading
from collections.abc import Sequence

from . import Failure, need_ros, options, say


def main(words: Sequence[str]) -> int:
    """Serves until interrupted."""
    parser = options.parser(
        "markers",
        "Serves handles for RViz: add an InteractiveMarkers display.",
    )
    parser.add_argument("topics", metavar="TOPIC", nargs="*", help="only of these")
    parser.add_argument(
        "--namespace", metavar="NS", default="/rosslt", help="of the display (default: /rosslt)"
    )
    arguments = parser.parse_args(words)
    need_ros()

    from rosslt_auto.ros.observer import CannotObserve, Observer, full_name
    from rosslt_auto.views.markers import HandleMarkers
    from rosslt_auto.views.session import Session

    with Observer("markers") as observer:
        try:
            namespace = full_name(arguments.namespace.rstrip("/"))
            with Session(observer, arguments.topics) as session:
                session.messages.append(lambda text: say(text) if text else None)
                markers = HandleMarkers(session, observer.node, namespace)
                try:
                    print(f"{namespace}/update", flush=True)
                    say("press Ctrl-C to end")
                    markers.run(threading.Event())
                finally:
                    markers.close()
        except CannotObserve as reason:
            raise Failure(str(reason)) from None
    return 0
