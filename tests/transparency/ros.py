"""The public ROS 2 examples and demos as cases; `tools.run_public_nodes` runs and compares them."""

from __future__ import annotations

import importlib.util
import subprocess
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tools.run_public_nodes import Checkout, How, cases, check
from transparency.comparing import Difference, Result
from transparency.running import BUILD
from transparency.suites import Case, table

_SECONDS = 6.0
_MORE_SECONDS = 40.0


def results(folder: Path | None, jobs: int) -> Iterator[Result]:
    """A result for each program of a folder with checkouts; None: they are cloned."""
    if importlib.util.find_spec("rclpy") is None:
        yield Result(Case("ros", "examples and demos"), note="needs rclpy")
        return
    if folder is None:
        folder, problem = _clone()
        if problem:
            yield Result(Case("ros", "examples and demos"), note=f"not fetched: {problem}")
            return
    checkout = Checkout(folder.resolve(), [])
    with ThreadPoolExecutor(jobs) as pool:
        yield from pool.map(lambda case: _result(checkout, *case), cases(checkout, ""))


def _clone() -> tuple[Path, str]:
    """The folder with the repositories, and what was wrong if they are not there."""
    folder = BUILD / "ros"
    for name, row in table("ros")["repositories"].items():
        target = folder / name
        if target.exists():
            continue
        command = ["git", "clone", "--quiet", "--depth", "1", "--branch", row["branch"]]
        try:
            done = subprocess.run(
                [*command, row["url"], str(target)], capture_output=True, text=True, timeout=120
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            return folder, str(error)
        if done.returncode:
            return folder, (done.stderr.strip().splitlines() or ["git failed"])[-1]
    return folder, ""


def _result(checkout: Checkout, file: Path, variant: str, how: How) -> Result:
    found = check(checkout, file, variant, how, _SECONDS)
    if found.difference.startswith("DIFFERENT"):
        # A busy machine has found a partner too late, perhaps.
        found = check(checkout, file, variant, how, _MORE_SECONDS)
    result = Result(Case("ros", found.program), tests=1, note=found.difference)
    if found.difference.startswith("needs"):
        result.tests = 0
    elif found.difference.startswith("DIFFERENT"):
        result.surprises.append(Difference(found.program, "", "; ".join(found.details)))
    return result
