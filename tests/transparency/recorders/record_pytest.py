"""Runs pytest and records each test: ``record_pytest RECORDING FORGET ARG...``.

FORGET is a comma-separated list of patterns of modules to import again, see `recording.forget`.
"""

import os
import sys

import recording


class Plugin:
    """Records what pytest finds out about each test."""

    def __init__(self, record: recording.Recording) -> None:
        self.record = record
        self.errors: dict[str, list[dict]] = {}

    def pytest_runtest_makereport(self, item, call) -> None:
        if call.excinfo is not None:
            self.errors[item.nodeid, call.when] = recording.raised(call.excinfo.value)

    def pytest_runtest_logreport(self, report) -> None:
        if report.when != "call" and report.outcome == "passed":
            return
        what = report.outcome if not hasattr(report, "wasxfail") else f"x{report.outcome}"
        name = report.nodeid if report.when == "call" else f"{report.nodeid} ({report.when})"
        details = {}
        if report.outcome == "failed":
            details["raised"] = self.errors.pop((report.nodeid, report.when), [])
        self.record.add(name, what, **details)

    def pytest_collectreport(self, report) -> None:
        if report.outcome != "passed":
            self.record.add(f"{report.nodeid} (collected)", report.outcome)


def main() -> int:
    path, patterns, *arguments = sys.argv[1:]
    record = recording.Recording(path)
    import pytest

    recording.forget([pattern for pattern in patterns.split(",") if pattern])
    # Recorded are tests; what pytest writes has times in it.
    quiet = ["-q", "--no-header", "--no-summary", "--tb=no", "-p", "no:cacheprovider"]
    status = pytest.main([*quiet, *arguments], plugins=[Plugin(record)])
    record.add("", "end", reason=f"exit status {int(status)}")
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    sys.exit(main())
