"""Answers requests to nodes that do not spin.

A node that publishes in a loop of its own, ``while rclpy.ok(): ... time.sleep(0.1)``, never
answers parameter services. One thread of ours does it beside the program, with a wait set that
holds only those services and the subscription of source changes - nothing of the program's. It
steps aside at once when the program spins the node, for an entity must not be in two wait sets
(rcl_wait). What changes something runs in the program's own thread when it publishes next or
begins to spin, and in ours only if it does neither for a while.

Join point: `rclpy.executors.Executor.wait_for_ready_callbacks`, where executors wait.
"""

from __future__ import annotations

import atexit
import logging
import os
import threading
import time
import weakref
from collections.abc import Callable
from contextlib import ExitStack, suppress
from typing import Any

from rcl_interfaces.srv import SetParameters, SetParametersAtomically
from rclpy.exceptions import InvalidHandle
from rclpy.executors import Executor
from rclpy.impl.implementation_singleton import rclpy_implementation as _rclpy

from ..provenance.frames import unseen
from ..provenance.joinpoints import JoinPoints
from . import changes, parameters

GRACE = 0.15
"""Seconds that a change waits for the program's own thread."""

RECENTLY = 0.25
"""Seconds for which a node that was spun counts as spinning."""

WAIT = 1.0
"""Seconds after which the thread looks around even if nothing happens."""

_log = logging.getLogger(__name__)


# ---------------------------------------------------------------- in the program's own thread


class _Job:
    def __init__(self, node: Any, action: Callable[[], Any]) -> None:
        self.node = node
        self.action = action
        self.done = threading.Event()
        self.result: Any = None
        self.error: BaseException | None = None

    def run(self) -> None:
        try:
            self.result = self.action()
        except Exception as error:
            self.error = error
        finally:
            self.done.set()


pending: list[_Job] = []
"""What waits for the program's thread. Empty nearly always: ask before `run_pending`."""

_pending_lock = threading.Lock()


def run_pending(node: Any = None) -> None:
    """Does what waits for a node (or all nodes). Called where the node's own thread comes by."""
    with _pending_lock:
        mine = [job for job in pending if node is None or job.node is node]
        for job in mine:
            pending.remove(job)
    for job in mine:
        job.run()


def _in_its_thread(node: Any, action: Callable[[], Any]) -> Any:
    """The result of `action`, run by the thread that uses the node, or here if it does not come."""
    job = _Job(node, action)
    with _pending_lock:
        pending.append(job)
    if not job.done.wait(GRACE):
        with _pending_lock:
            left = job in pending
            if left:
                pending.remove(job)
        if left:
            job.run()
        else:
            job.done.wait()
    if job.error is not None:
        raise job.error
    return job.result


# ---------------------------------------------------------------- who is spun


class _Spinning:
    """What is known of executors: which are waiting now, and when they last were."""

    def __init__(self) -> None:
        self.waiting: dict[int, int] = {}
        self.last: weakref.WeakKeyDictionary[Any, float] = weakref.WeakKeyDictionary()

    def begin(self, executor: Any) -> None:
        self.waiting[id(executor)] = self.waiting.get(id(executor), 0) + 1

    def end(self, executor: Any) -> None:
        count = self.waiting[id(executor)] - 1
        if count:
            self.waiting[id(executor)] = count
        else:
            del self.waiting[id(executor)]
        self.last[executor] = time.monotonic()

    def spins(self, node: Any) -> bool:
        """Whether an executor takes care of the node."""
        executor = node.executor
        if executor is None:
            return False
        if not isinstance(executor, Executor):  # the events executor: in C++, not to be seen into
            return True
        if time.monotonic() - self.last.get(executor, -RECENTLY) < RECENTLY:
            return True
        if node not in executor._nodes:
            return False
        return id(executor) in self.waiting or bool(executor._work_tracker._num_work_executing)


# ---------------------------------------------------------------- the thread


class _Server:
    """The thread and what it watches. `turn` guards everything here."""

    def __init__(self) -> None:
        self.turn = threading.Condition()
        self.spinning = _Spinning()
        self.nodes: weakref.WeakSet[Any] = weakref.WeakSet()
        self.thread: threading.Thread | None = None
        self.guards: weakref.WeakKeyDictionary[Any, Any] = weakref.WeakKeyDictionary()
        self.in_wait: Any = None  # the guard condition of the wait set in use
        self.serving: Any = None  # the node whose request is being answered
        self.away = 0  # how many executors are about to wait
        self.stopped = False

    # Called by the program's threads

    def watch(self, node: Any) -> None:
        """Serves a node from now on whenever it is not spun."""
        with self.turn:
            self.nodes.add(node)
            self._wake()
            if self.thread is None and not self.stopped:
                self.thread = threading.Thread(
                    target=self._run, name="rosslt_auto serving", daemon=True
                )
                self.thread.start()
                # An interpreter that ends takes the middleware down: not below a waiting thread.
                atexit.register(self.stop)

    def forget(self, node: Any) -> None:
        """Lets go of a node that is about to be destroyed."""
        with self.turn:
            self.nodes.discard(node)
            self._step_aside()
        run_pending(node)
        with self.turn:
            if threading.current_thread() is not self.thread:
                self.turn.wait_for(lambda: self.serving is not node, WAIT)

    def stop(self) -> None:
        """Ends the thread."""
        with self.turn:
            self.stopped = True
            self._wake()
        run_pending()
        if self.thread is not None and threading.current_thread() is not self.thread:
            self.thread.join(2 * WAIT)
        self.guards.clear()

    def begin_spin(self, executor: Any) -> None:
        """An executor is about to wait: its nodes are its own."""
        with self.turn:
            self.spinning.begin(executor)
            if self.in_wait is not None:
                self._step_aside()
        if pending:
            run_pending()

    def end_spin(self, executor: Any) -> None:
        """An executor has stopped waiting, perhaps only to run a callback."""
        with self.turn:
            self.spinning.end(executor)

    def _wake(self) -> None:
        if self.in_wait is not None:
            with suppress(InvalidHandle), self.in_wait:
                self.in_wait.trigger_guard_condition()
        self.turn.notify_all()

    def _step_aside(self) -> None:
        """Returns when the thread is in no wait set; with `turn` held throughout it stays so."""
        self.away += 1
        try:
            self._wake()
            self.turn.wait_for(lambda: self.in_wait is None, WAIT)
        finally:
            self.away -= 1

    # The thread itself

    def _run(self) -> None:
        while True:
            with self.turn:
                if self.stopped:
                    return
                served = self._served()
                if not served:
                    self.turn.wait(RECENTLY if self.nodes else None)
                    continue
            try:
                self._serve(served)
            except Exception:
                # A node or a context that went away in between; look again who is left.
                _log.debug("serving", exc_info=True)
                with self.turn:
                    self.turn.wait(RECENTLY)

    def _served(self) -> list[Any]:
        """The nodes that nobody spins, of one context."""
        if self.away:
            return []
        nodes = [node for node in self.nodes if node.context.ok() and not self.spinning.spins(node)]
        return [node for node in nodes if node.context is nodes[0].context]

    def _serve(self, nodes: list[Any]) -> None:
        """Waits once for a request to one of the nodes and answers what is there."""
        context = nodes[0].context
        guard = self._guard(context)
        entities = [(node, *entity) for node in nodes for entity in _entities(node)]
        with ExitStack() as handles:
            handles.enter_context(context.handle)
            handles.enter_context(guard)
            for _, entity, _ in entities:
                handles.enter_context(entity.handle)
            wait_set = _wait_set(context, guard, entities)
            handles.enter_context(wait_set)
            with self.turn:
                if self.stopped or set(self._served()) != set(nodes):
                    return
                self.in_wait = guard
            try:
                wait_set.wait(int(WAIT * 1e9))
            finally:
                with self.turn:
                    self.in_wait = None
                    self.turn.notify_all()
            ready = {
                *wait_set.get_ready_entities("service"),
                *wait_set.get_ready_entities("subscription"),
            }
            for node, entity, answer in entities:
                if entity.handle.pointer in ready:
                    self._answer(node, entity, answer)

    def _guard(self, context: Any) -> Any:
        guard = self.guards.get(context)
        if guard is None:
            with context.handle:
                guard = self.guards[context] = _rclpy.GuardCondition(context.handle)
        return guard

    def _answer(self, node: Any, entity: Any, answer: Callable[[Any, Any], None]) -> None:
        with self.turn:
            if node not in self.nodes or self.stopped:
                return
            self.serving = node
        try:
            answer(node, entity)
        except Exception as error:
            # What a callback of the program raises ends a spinning node; here it ends nothing.
            _log.warning("a request to %s was not answered: %s", node.get_name(), error)
        finally:
            with self.turn:
                self.serving = None
                self.turn.notify_all()


def _entities(node: Any) -> list[tuple[Any, Callable[[Any, Any], None]]]:
    """The parameter services of a node and its subscription of source changes."""
    service = getattr(node, "_parameter_service", None)
    return [
        *(
            (one, _answer_request)
            for one in list(node.services)
            if service is not None and getattr(one.callback, "__self__", None) is service
        ),
        *((one, _take_change) for one in list(node.subscriptions) if changes.is_listener(one)),
    ]


def _wait_set(context: Any, guard: Any, entities: list[tuple[Any, Any, Any]]) -> Any:
    services = [entity for _, entity, answer in entities if answer is _answer_request]
    subscriptions = [entity for _, entity, answer in entities if answer is _take_change]
    wait_set = _rclpy.WaitSet(len(subscriptions), 1, 0, 0, len(services), 0, context.handle)
    wait_set.clear_entities()
    wait_set.add_guard_condition(guard)
    for service in services:
        wait_set.add_service(service.handle)
    for subscription in subscriptions:
        wait_set.add_subscription(subscription.handle)
    return wait_set


def _answer_request(node: Any, service: Any) -> None:
    request, header = service.handle.service_take_request(service.srv_type.Request)
    if header is None:
        return
    response = service.srv_type.Response()
    if service.srv_type in (SetParameters, SetParametersAtomically):
        response = _in_its_thread(node, lambda: service.callback(request, response))
    else:
        response = service.callback(request, response)
    service.send_response(response, header)


def _take_change(node: Any, subscription: Any) -> None:
    taken = subscription.handle.take_message(subscription.msg_type, False)
    if taken is not None:
        _in_its_thread(node, lambda: subscription.callback(taken[0]))


# ---------------------------------------------------------------- weaving

_points = JoinPoints()
_server = _Server()


@unseen
def _wait_advice(wrapped: Any, executor: Any, args: Any, kwargs: Any) -> Any:
    server = _server
    if not server.nodes:
        return wrapped(*args, **kwargs)
    server.begin_spin(executor)
    try:
        return wrapped(*args, **kwargs)
    finally:
        server.end_spin(executor)


def _forked() -> None:
    """In a forked process there is no thread of ours: it begins anew with the next location."""
    global _server, _pending_lock
    atexit.unregister(_server.stop)
    _server = _Server()
    _pending_lock = threading.Lock()
    pending.clear()


os.register_at_fork(after_in_child=_forked)


def _watch(node: Any) -> None:
    _server.watch(node)


def _forget(node: Any) -> None:
    _server.forget(node)


def install() -> None:
    """Nodes are served from their first location on. Once; after `changes`."""
    if not _points:
        _points.advise(Executor, "wait_for_ready_callbacks", _wait_advice)
        parameters.on_first_location.append(_watch)
        parameters.on_release.append(_forget)


def uninstall() -> None:
    """Ends the thread and takes the advice off."""
    global _server
    if not _points:
        return
    _points.restore()
    parameters.on_first_location.remove(_watch)
    parameters.on_release.remove(_forget)
    _server.stop()
    atexit.unregister(_server.stop)
    _server = _Server()


__all__ = ["GRACE", "install", "pending", "run_pending", "uninstall"]
