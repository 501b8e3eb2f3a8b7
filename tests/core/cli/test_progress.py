"""What a run shows of its progress: a bar on a terminal, lines elsewhere."""

from __future__ import annotations

import sys
from contextlib import closing
from io import StringIO

import pytest

from followspot.cli import progress
from followspot.cli.progress import ProgressBar
from followspot.control.progress import Progress


class Terminal(StringIO):
    def isatty(self) -> bool:
        return True


def terminal(monkeypatch: pytest.MonkeyPatch) -> Terminal:
    """Standard error for the rest of a test."""
    made = Terminal()
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setenv("COLUMNS", "120")
    monkeypatch.setattr(sys, "stderr", made)
    return made


def test_a_terminal_shows_a_bar_with_lines_above_it_and_keeps_standard_output(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seen = terminal(monkeypatch)
    with closing(ProgressBar()) as bar:
        bar.show(Progress(10, 0, ("host [pc] is absent", "b")), 100)
        bar.say("a line " * 30 + "[red]")
        print("result")
        bar.show(Progress(100, 0, ()), 100)
    shown = seen.getvalue()
    assert "10/100 frames" in shown
    assert "! host [pc] is absent (+1)" in shown
    assert "a line " * 30 + "[red]\n" in shown
    assert shown.rindex("100/100 frames") > shown.index("a line")
    assert shown.endswith("\x1b[?25h")  # the cursor is visible again
    assert capsys.readouterr().out == "result\n"


def test_a_run_of_unknown_length_has_frames_and_no_end(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = terminal(monkeypatch)
    with closing(ProgressBar()) as bar:
        bar.show(Progress(7, 0, ()), None)
    assert "7 frames  0/s" in seen.getvalue()


def test_quiet_runs_draw_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = terminal(monkeypatch)
    with closing(ProgressBar()) as bar:
        bar.say("warning")
    assert seen.getvalue() == "warning\n"


def test_a_terminal_that_cannot_go_back_gets_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    seen = terminal(monkeypatch)
    monkeypatch.setenv("TERM", "dumb")
    with closing(ProgressBar()) as bar:
        bar.show(Progress(7, 0, ("host a is absent",)), None)
    assert "7 frames" in seen.getvalue()
    assert "\x1b" not in seen.getvalue()


def test_a_pipe_gets_a_line_now_and_then_and_when_faults_come_and_go(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    now = 100.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    bar = ProgressBar()
    bar.show(Progress(1, 0, ()), 100)
    now += 5.0
    bar.show(Progress(50, 0, ()), 100)
    now += 1.0
    bar.show(Progress(50, 0, ("host a is absent",)), 100)
    bar.show(Progress(50, 0, ("host a is absent",)), 100)
    now += 1.0
    bar.show(Progress(50, 0, ()), 100)
    now += 5.0
    bar.show(Progress(50, 0, ()), 100)
    bar.close()
    assert capsys.readouterr().err.splitlines() == [
        "50/100 frames  10/s  5 s left",
        "50/100 frames  0/s  ! host a is absent",
        "50/100 frames  0/s",
        "50/100 frames  0/s",
    ]
