"""Ends in the way that its argument says, with numbers in all of them."""

import asyncio
import logging
import sys
import threading
import warnings

LIMIT = 3
RATE = 2.5


def divide(a, b=0):
    return a / (b * RATE)


def chained():
    try:
        [1, 2][LIMIT]
    except IndexError as error:
        error.add_note(f"limit {LIMIT}")
        raise ValueError(f"no more than {LIMIT}", RATE) from error


def group():
    errors = []
    for action in (lambda: divide(1), lambda: "a" + LIMIT, lambda: int("x" * 3)):
        try:
            action()
        except Exception as error:
            errors.append(error)
    raise ExceptionGroup("several", errors)


def thread():
    threading.excepthook = lambda args: sys.excepthook(*args[:3])
    worker = threading.Thread(target=divide, args=(LIMIT,), name="worker")
    worker.start()
    worker.join()


def exit():
    sys.exit(LIMIT + 1)


def message():
    sys.exit(f"stopped at {RATE:.3f} of {LIMIT!r}")


def logged():
    logging.basicConfig(format="%(levelname)s:%(funcName)s:%(lineno)d:%(message)s", level=10)
    logging.info("rate %5.2f limit %d %s", RATE, LIMIT, RATE)
    try:
        divide(RATE)
    except ZeroDivisionError:
        logging.exception("it failed after %s", LIMIT)


async def task(n):
    await asyncio.sleep(0)
    return divide(n, n - 1)


async def tasks():
    print(await asyncio.gather(*(task(n) for n in range(LIMIT)), return_exceptions=True))
    await task(1)


ACTIONS = {
    "chained": chained,
    "group": group,
    "thread": thread,
    "exit": exit,
    "message": message,
    "warnings": lambda: warnings.warn(f"rate {RATE}", RuntimeWarning, stacklevel=1 + 1),
    "logging": logged,
    "asyncio": lambda: asyncio.run(tasks()),
}

if __name__ == "__main__":
    ACTIONS[sys.argv[1]]()
