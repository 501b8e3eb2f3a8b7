"""The progress of a run on standard error: what is done, how fast it goes now, and what is absent."""

from __future__ import annotations

import io

import pytest

from followspot.cli.progress import ProgressBar
from followspot.runtime.worker import Progress

FAULT = "host pc-left is absent: last heard 12 s ago"


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


class Shown:
    """A bar, and the time that it goes by, s."""

    def __init__(self, stream: io.StringIO) -> None:
        self.now = 0.0
        self.stream = stream
        self.bar = ProgressBar(stream, lambda: self.now)

    def show(self, fired: int, *faults: str, after: float = 1.0, expected: int | None = None) -> str:
        """What is written when so many frames are done that much later."""
        self.now += after
        before = len(self.stream.getvalue())
        self.bar.show(Progress(fired, 0, faults), expected)
        return self.stream.getvalue()[before:].rstrip("\n")


def test_the_rate_is_that_of_the_last_seconds_and_not_of_the_whole_run() -> None:
    shown = Shown(Terminal())
    for second in range(60):
        line = shown.show(30 * second)
    assert line.endswith("1770 frames  30/s")
    for _ in range(6):
        line = shown.show(1770)
    assert line.endswith("1770 frames  0/s")  # it stands still, however long it ran


def test_a_run_that_is_joined_late_begins_with_no_rate() -> None:
    shown = Shown(Terminal())
    assert shown.show(1_000_000).endswith("1000000 frames  0/s")
    assert shown.show(1_000_030).endswith("1000030 frames  30/s")


def test_what_is_absent_is_told_at_once_in_the_colour_of_a_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    shown = Shown(Terminal())
    shown.show(30, expected=100)
    line = shown.show(60, FAULT, "worker left is starting again", expected=100)
    assert "60/100 frames  30/s  1 s left" in line
    assert f"\x1b[1;31m! {FAULT} (+1)\x1b[0m" in line
    assert "\x1b" not in shown.show(90, expected=100).removeprefix("\r\x1b[K")


def test_a_line_of_a_terminal_is_no_longer_than_that(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "30")
    line = Shown(Terminal()).show(60, FAULT).removeprefix("\r\x1b[K")
    plain = line.replace("\x1b[1;31m", "").replace("\x1b[0m", "")
    assert plain == ("60 frames  0/s  ! " + FAULT)[:29]


def test_where_there_is_no_terminal_a_line_comes_when_something_goes_or_is_back() -> None:
    shown = Shown(io.StringIO())
    assert shown.show(10, after=0.2) == ""
    assert shown.show(12, FAULT, "another", after=0.2) == f"12 frames  10/s  ! {FAULT} (+1)"
    assert shown.show(14, FAULT, after=0.2) == ""
    assert shown.show(16, after=0.2) == "16 frames  10/s"
    assert shown.show(18, after=0.2) == ""
    assert shown.show(66, after=4.8) == "66 frames  10/s"
