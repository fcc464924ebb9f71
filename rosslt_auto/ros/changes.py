"""The paper's SourceChange message: fire and forget, on ``/rosslt/source_change``.

rcl_interfaces/msg/ParameterEvent; what stands in `changed_parameters` for a node of this
process is set exactly as through its parameter services, together or not at all.

What stands in `new_parameters` tells a node that values have been saved (`saving`): the name of
each is the path of a source file that the node's process has loaded, its value a text of JSON,
``{"before": F, "after": G, "edits": [[line, column, end_line, end_column, text, value], ...]}``.
F and G are the fingerprints (`locations.fingerprint`) of what was loaded and of what the file has
now, an edit is the place of a literal in what was loaded, its new text, and the value of that. A
node believes it if the file says the same; then it knows the literals at their new places, with
their new first values.
"""

from __future__ import annotations

import json
import logging
import weakref
from collections.abc import Sequence
from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rclpy.exceptions import ParameterNotDeclaredException
from rclpy.parameter import Parameter
from rclpy.qos import qos_profile_parameter_events

from rosslt_auto.provenance import saved

from . import parameters

TOPIC = "/rosslt/source_change"

_log = logging.getLogger(__name__)


def listen(node: Any) -> None:
    """Subscribes a node. In its default callback group: between callbacks, as the services."""
    try:
        node.create_subscription(
            ParameterEvent, TOPIC, _Listener(node), qos_profile_parameter_events
        )
    except Exception:
        # The node is being shut down. It goes on without.
        _log.debug("no subscription of %s", TOPIC, exc_info=True)


class _Listener:
    """The callback; tells itself apart from the program's own."""

    def __init__(self, node: Any) -> None:
        self._node = weakref.ref(node)

    def __call__(self, event: Any) -> None:
        node = self._node()
        if node is not None:
            apply(node, event)


def is_listener(subscription: Any) -> bool:
    """Whether a subscription is one of `listen`."""
    return isinstance(subscription.callback, _Listener)


def apply(node: Any, event: Any) -> None:
    """Applies an event if it is meant for `node`; what is refused is logged."""
    if event.node != node.get_fully_qualified_name():
        return
    for one in event.new_parameters:
        _adopt(node, one.name, one.value.string_value)
    if not event.changed_parameters:
        return
    try:
        requested = [Parameter.from_parameter_msg(one) for one in event.changed_parameters]
        result = node.set_parameters_atomically(requested)
    except ParameterNotDeclaredException as error:
        _refused(node, str(error))
    except (TypeError, ValueError) as error:  # a message that is no parameter
        _refused(node, f"malformed: {error}")
    else:
        if not result.successful:
            _refused(node, result.reason)


def saved_parameter(path: str, before: str, after: str, edits: Sequence[saved.LiteralEdit]) -> Any:
    """The message that tells a node of edits of a file: one of `new_parameters`, see above."""
    news = {"before": before, "after": after, "edits": edits}
    return Parameter(path, value=json.dumps(news)).to_parameter_msg()


def _adopt(node: Any, path: str, text: str) -> None:
    try:
        news = json.loads(text)
        edits = [saved.LiteralEdit(*edit) for edit in news["edits"]]
        for edit in edits:
            if not all(type(number) is int for number in edit[:4]) or type(edit.text) is not str:
                raise TypeError(f"no edit: {edit}")
        saved.adopt(path, news["before"], news["after"], edits)
    except saved.NotSaved as reason:
        _refused(node, str(reason))
    except (ValueError, TypeError, LookupError, RecursionError) as error:
        _refused(node, f"malformed: {error!r}")


def _refused(node: Any, reason: str) -> None:
    node.get_logger().warning(f"source change refused: {reason}")


def install() -> None:
    """Nodes listen from their first location on."""
    if listen not in parameters.on_first_location:
        parameters.on_first_location.append(listen)


def uninstall() -> None:
    """No further node listens."""
    if listen in parameters.on_first_location:
        parameters.on_first_location.remove(listen)
