"""What a run shows of its progress: a bar on a terminal, lines elsewhere."""

from __future__ import annotations

import re
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


@pytest.mark.parametrize("pipe", [True, False])
def test_the_rate_after_a_pause_of_the_operator_is_that_of_the_run(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], pipe: bool
) -> None:
    """10 frames a second all the time; the first state after the pause is as old as the pause."""
    seen = None if pipe else terminal(monkeypatch)
    now = 100.0
    monkeypatch.setattr(progress.time, "monotonic", lambda: now)
    with closing(ProgressBar()) as bar:
        for now in (105.0, 110.0):
            bar.show(Progress(round(10 * (now - 100.0)), 0, ()), 90000)
        now = 710.0
        bar.show(Progress(100, 0, ()), 90000)
        for now in (710.001, 710.002, 711.0, 715.5, 716.0, 720.0):
            faults = ("host a is absent",) if now == 710.002 else ()
            bar.show(Progress(round(10 * (now - 100.0)), 0, faults), 90000)
    shown = capsys.readouterr().err if seen is None else seen.getvalue()
    rates = {int(rate) for rate in re.findall(r"frames +(\d+)/s", shown)}
    assert rates == {10, 0}
    assert "6200/90000 frames  10/s" in shown or pipe
