"""ROS domains that nobody else on this machine is using, as far as one can know.

A lock file for each domain keeps parallel test runs apart. The lock belongs to the process and goes
with it, however it ends; the files stay.
"""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

# Above 101 the ports of DDS run into the range that Linux hands out to anybody.
DOMAINS = range(1, 100)

_LOCKS = Path(tempfile.gettempdir()) / "ros-domain-locks"
_next = os.getpid()


@contextmanager
def reserved_domain() -> Iterator[int]:
    """A domain number that no other user of this function has until the block is left."""
    global _next
    _LOCKS.mkdir(mode=0o1777, exist_ok=True)
    for _ in DOMAINS:
        domain = DOMAINS[_next % len(DOMAINS)]
        _next += 1
        lock = os.open(_LOCKS / str(domain), os.O_RDWR | os.O_CREAT, 0o666)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(lock)
            continue
        try:
            yield domain
        finally:
            os.close(lock)
        return
    raise RuntimeError(f"all ROS domains from {DOMAINS[0]} to {DOMAINS[-1]} are in use")
