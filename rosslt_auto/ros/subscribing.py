"""Subscribing: fields of received messages get the provenance that came in a header.

Join points: `Node.create_subscription`, and the subscription handle that rclpy makes there. Every
executor, `wait_for_message` and whoever polls by hand take messages from that handle, so it is
replaced by a subclass with advice of its own: what is taken is what would have been taken, with
tracked values in it.

`Headers` alone serves whoever subscribes raw.
"""

from __future__ import annotations

import logging
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.type_support import check_for_type_support
from std_msgs.msg import UInt8MultiArray

from ..provenance.frames import unseen_methods
from . import fields, header
from .handles import WovenHandles, disconnect, header_qos
from .header import Header, HeaderError

PATIENCE = 0.001
"""Seconds that a message waits for a header that is late."""

PATIENCE_AT_FIRST = 0.005
"""The same before any header has come: what was sent while nodes found each other is sent again,
not always in order."""

_MAX_BYTES = 8 << 20
_STEP = 50e-6
_MAX_DISAPPOINTMENTS = 4
_TRUSTED = 4

_log = logging.getLogger(__name__)

_plain_handle: Any = _rclpy.Subscription
_take = _plain_handle.take_message
_destroy = _plain_handle.destroy_when_not_in_use
_publisher_count = _plain_handle.get_publisher_count
_deserialise = _rclpy.rclpy_deserialize


class _Handle(_plain_handle):
    """rclpy's subscription handle with our advice; without `headers` it is just that."""

    headers: Headers | None = None

    def __init__(self, node_handle: Any, *args: Any) -> None:
        woven.make(self, node_handle, *args)

    def take_message(self, message_type: type, raw: bool) -> Any:
        headers = self.headers
        if headers is None or not headers.expected():
            return _take(self, message_type, raw)
        if headers.trusted and not raw and _publisher_count(self) == 1:
            taken = _take(self, message_type, False)
            if taken is not None:
                found = headers.match_sequence(taken[1])
                if found is not None:
                    headers.attach(taken[0], found)
            return taken
        taken = _take(self, message_type, True)
        if taken is None:
            return None
        data, info = taken
        found = headers.match(data, info)
        if raw:
            return taken
        try:
            message = _deserialise(data, message_type)
        except _rclpy.RMWError:
            return None  # plain, rcl_take does not even return what cannot be deserialised
        if found is not None:
            headers.attach(message, found)
        return message, info

    def destroy_when_not_in_use(self) -> None:
        disconnect(self)
        _destroy(self)


unseen_methods(_Handle)  # errors of the plain methods pass through as if we were not there


class Headers:
    """The header topic beside a topic, and the headers whose messages have not come yet.

    matched    how many messages have got their header
    malformed  how many headers could not be used
    """

    def __init__(self, node: Node, topic: str, qos: QoSProfile) -> None:
        """topic is the resolved name of the topic, qos the subscription's quality of service."""
        self.topic = topic
        self.matched = 0
        self.malformed = 0
        profile = header_qos(qos)
        self._limit = 2 * profile.depth
        self._next: Header | None = None  # just read: most probably that of the next message
        self._waiting: dict[int, list[Header]] = {}  # by checksum
        self._count = 0
        self._bytes = 0
        self._seen = False
        self._misses = 0  # messages without header, one after another
        self._disappointments = 0
        self._without: deque[int | None] = deque(maxlen=16)  # checksums of messages without
        self._agreed = 0  # messages whose header had their sequence number, one after another
        self._warned = False
        self._lock = threading.RLock()
        check_for_type_support(UInt8MultiArray)
        with node.handle:
            self._handle = _plain_handle(
                node.handle, UInt8MultiArray, topic + header.SUFFIX, profile.get_c_qos_profile()
            )

    @property
    def trusted(self) -> bool:
        """Whether sequence numbers have proved to be enough to match headers.

        As long as there is only one publisher; the checksum costs taking the message raw.
        """
        return self._agreed >= _TRUSTED

    def expected(self) -> bool:
        """Whether the next message may have a header; if not, nothing has to be matched."""
        if self._next is not None or self._waiting:
            return True
        try:
            with self._lock:
                self._next = self._read()
                return self._next is not None or _publisher_count(self._handle) > 0
        except Exception:  # destroyed by another thread, the context shut down
            return False

    def match(self, data: bytes, info: Any) -> Header | None:
        """The header of a message.

        data  the serialised message
        info  its message info, a mapping with the publication sequence number
        """
        try:
            checksum = header.checksum_of(data)
            sequence = info["publication_sequence_number"]
            with self._lock:
                found, self._next = self._next, None
                if found is None or found.checksum != checksum or found.sequence != sequence:
                    if found is not None:
                        self._keep(found)
                    found = self._take(checksum, sequence, exactly=True) or self._search(
                        lambda: self._take(checksum, sequence)
                    )
                if found is None:
                    self._missed(checksum)
                else:
                    self.matched += 1
                    self._misses = 0
                    self._agreed = self._agreed + 1 if found.sequence == sequence else 0
            return found
        except Exception as error:  # never the program's business
            self._warn(repr(error))
            return None

    def match_sequence(self, info: Any) -> Header | None:
        """The header of a message of the only publisher, if `trusted`."""
        try:
            sequence = info["publication_sequence_number"]
            with self._lock:
                found, self._next = self._next, None
                if found is None or found.sequence != sequence:
                    if found is not None:
                        self._keep(found)
                    found = self._search(lambda: self._take_sequence(sequence))
                if found is None:
                    self._agreed = 0  # perhaps it is not enough any more
                    self._missed(None)
                else:
                    self.matched += 1
                    self._misses = 0
            return found
        except Exception as error:
            self._warn(repr(error))
            return None

    def _missed(self, checksum: int | None) -> None:
        self._without.append(checksum)
        self._misses += 1
        if self._misses > self._limit:  # what waits has lost its message
            self._forget()

    def attach(self, message: Any, found: Header) -> None:
        """`fields.attach`, for which a header may turn out to be malformed."""
        try:
            fields.attach(message, found)
        except HeaderError as error:
            self._refuse(error)

    def _search(self, take: Callable[[], Header | None]) -> Header | None:
        """A header among those that have come by now, or come within moments."""
        self._read_all()
        found = take()
        if found is None and self._worth_waiting():
            end = time.monotonic() + (PATIENCE if self._seen else PATIENCE_AT_FIRST)
            while found is None and time.monotonic() < end:
                time.sleep(_STEP)
                self._read_all()
                found = take()
            self._disappointments = 0 if found is not None else self._disappointments + 1
        return found

    def _worth_waiting(self) -> bool:
        """Headers come first, so one that is missing is hardly ever late."""
        return self._disappointments < _MAX_DISAPPOINTMENTS and _publisher_count(self._handle) > 0

    def _take(self, checksum: int, sequence: int | None, exactly: bool = False) -> Header | None:
        """The waiting header of a message.

        The sequence number tells equal messages apart, but not every middleware has it.
        """
        candidates = self._waiting.get(checksum)
        if not candidates:
            return None
        for found in candidates:
            if found.sequence == sequence:
                break
        else:
            if exactly:
                return None
            found = candidates[0]
        self._remove(checksum, candidates, found)
        return found

    def _take_sequence(self, sequence: int) -> Header | None:
        for checksum, candidates in self._waiting.items():
            for found in candidates:
                if found.sequence == sequence:
                    self._remove(checksum, candidates, found)
                    return found
        return None

    def _read(self) -> Header | None:
        """The next header in the queue, None if there is none."""
        for _ in range(self._limit):
            taken = _take(self._handle, UInt8MultiArray, True)
            if taken is None:
                return None
            self._seen = True
            try:
                found = header.decode(header.unwrap(taken[0]))
            except HeaderError as error:
                self._refuse(error)
                continue
            if self._without and found.checksum in self._without:
                self._disappointments = 0  # it was late: waiting would have helped
            return found
        return None

    def _read_all(self) -> None:
        for _ in range(self._limit):
            found = self._read()
            if found is None:
                return
            self._keep(found)

    def _keep(self, found: Header) -> None:
        self._waiting.setdefault(found.checksum, []).append(found)
        self._count += 1
        self._bytes += found.size
        while self._count > self._limit or self._bytes > _MAX_BYTES:
            checksum = next(iter(self._waiting))
            candidates = self._waiting[checksum]
            self._remove(checksum, candidates, candidates[0])

    def _remove(self, checksum: int, candidates: list[Header], found: Header) -> None:
        candidates.remove(found)
        if not candidates:
            del self._waiting[checksum]
        self._count -= 1
        self._bytes -= found.size

    def _forget(self) -> None:
        self._waiting.clear()
        self._count = self._bytes = self._misses = 0

    def _refuse(self, error: HeaderError) -> None:
        self.malformed += 1
        self._warn(f"malformed, {error}")

    def _warn(self, reason: str) -> None:
        if not self._warned:
            self._warned = True
            _log.warning("a provenance header on %s is ignored: %s", self.topic, reason)

    def destroy(self) -> None:
        """Ends the subscription of the header topic."""
        self._handle.destroy_when_not_in_use()
        with self._lock:
            self._forget()


def _headers(node: Node, message_type: type, topic: str, qos: QoSProfile) -> Headers:
    return Headers(node, topic, qos)


woven = WovenHandles("create_subscription", "Subscription", _Handle, _headers)
install = woven.install
uninstall = woven.uninstall

__all__ = ["Headers", "install", "uninstall"]
