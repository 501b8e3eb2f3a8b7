"""A pytest plugin (`-p mutation.probe`): how long each test takes, which lines it reaches, none without end.

MUTANTS_LOG names a file that takes a line of JSON when a test begins, and when it has ended.
MUTANTS_LIMITS names a JSON file with the seconds that each test may take.
"""

from __future__ import annotations

import faulthandler
import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

_LONGEST_S = 900.0


class _Log:
    def __init__(self) -> None:
        self.file = Path(os.environ["MUTANTS_LOG"]).open("a", buffering=1)  # noqa: SIM115
        self.limits: dict[str, float] = json.loads(Path(os.environ["MUTANTS_LIMITS"]).read_text())
        self.seconds = 0.0
        self.outcome = "passed"

    def write(self, **fields: object) -> None:
        self.file.write(json.dumps(fields) + "\n")


_LOG = _Log()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
    """Log the test, and end the process with it if it takes longer than it may."""
    _LOG.seconds, _LOG.outcome = 0.0, "passed"
    _LOG.write(begin=item.nodeid)
    faulthandler.dump_traceback_later(_LOG.limits.get(item.nodeid, _LONGEST_S), exit=True)
    try:
        result = yield
    finally:
        faulthandler.cancel_dump_traceback_later()
        _LOG.write(test=item.nodeid, seconds=round(_LOG.seconds, 3), outcome=_LOG.outcome)
    return result


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Add up the phases of a test."""
    _LOG.seconds += report.duration
    if report.outcome != "passed":
        _LOG.outcome = report.outcome


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Lines belong to the test from here on, in the words of the variable that processes inherit."""
    _switch(f"{item.nodeid} (setup)")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> None:
    """See `pytest_runtest_setup`."""
    _switch(f"{item.nodeid} (call)")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> None:
    """See `pytest_runtest_setup`."""
    _switch(f"{item.nodeid} (teardown)")


def _switch(context: str) -> None:
    coverage = _current_coverage()
    if coverage is not None:
        coverage.switch_context(context)


def _current_coverage() -> Any:
    try:
        from coverage import Coverage
    except ImportError:
        return None
    return Coverage.current()
