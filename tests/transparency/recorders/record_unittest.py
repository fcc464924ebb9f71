"""Runs unittest test modules and records each test: ``record_unittest RECORDING FORGET NAME...``.

FORGET is a comma-separated list of patterns of modules to import again, see `recording.forget`.
"""

import os
import sys

import recording


def main() -> int:
    path, patterns, *names = sys.argv[1:]
    record = recording.Recording(path)
    recording.forget([pattern for pattern in patterns.split(",") if pattern])
    import unittest

    class Result(unittest.TestResult):
        """Records; test modules' own output goes where it goes."""

        def __init__(self) -> None:
            super().__init__()
            self.failed: set[str] = set()

        def addSuccess(self, test) -> None:
            record.add(test.id(), "ok")

        def addError(self, test, err) -> None:
            record.add(test.id(), "error", raised=recording.raised(err[1]))

        def addFailure(self, test, err) -> None:
            record.add(test.id(), "failure", raised=recording.raised(err[1]))

        def addSkip(self, test, reason) -> None:
            record.add(test.id(), "skipped", reason=str(reason))

        def addExpectedFailure(self, test, err) -> None:
            record.add(test.id(), "expected failure")

        def addUnexpectedSuccess(self, test) -> None:
            record.add(test.id(), "unexpected success")

        def addSubTest(self, test, subtest, err) -> None:
            if err is not None:
                record.add(subtest.id(), "in a part", raised=recording.raised(err[1]))

        def addDuration(self, test, elapsed) -> None:
            pass

        def printErrors(self) -> None:
            pass

    if any(name.startswith("test.") for name in names):  # CPython's own
        from test import support

        support.use_resources = []
        support.verbose = 0
    suite = unittest.defaultTestLoader.loadTestsFromNames(names)
    suite.run(Result())
    sys.stdout.flush()
    record.add("", "end")
    os._exit(0)  # threads that a test has left behind are nobody's business


if __name__ == "__main__":
    sys.exit(main())
