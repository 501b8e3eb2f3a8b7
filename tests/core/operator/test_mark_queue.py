"""Marks reach the flight recorder of a run once, and the log says what became of them."""

from __future__ import annotations

import pytest

from followspot.control.dispatch import NoAnswer
from followspot.errors import FollowspotError, InputError
from followspot.library.keep_options import bytes_of, seconds_of
from followspot.log.record import Level
from followspot.operator.mark_queue import Mark, MarkQueue, Moment, RecorderState

KEPT = RecorderState(30.0, 2, 30.0, 100, 1000, 20, 0)


class Log:
    def __init__(self) -> None:
        self.now = 0.0
        self.lines: list[tuple[Level, str]] = []
        self.marks = MarkQueue(lambda level, text: self.lines.append((level, text)), lambda: self.now)


def test_a_mark_of_a_run_that_keeps_nothing_says_how_to_keep() -> None:
    with pytest.raises(FollowspotError, match="start it with --keep 30s"):
        Log().marks.mark(5.0, "")


def test_a_mark_is_handed_over_until_it_is_taken() -> None:
    log = Log()
    assert log.marks.exchange(KEPT, 0) == ()
    assert [log.marks.mark(5.0, "one"), log.marks.mark(1.0, "two")] == [1, 2]
    assert log.marks.exchange(KEPT, 0) == (Mark(1, 5.0, "one"), Mark(2, 1.0, "two"))
    assert log.marks.exchange(KEPT, 1) == (Mark(2, 1.0, "two"),)
    assert log.marks.exchange(KEPT, 2) == ()
    assert log.marks.kept == KEPT


def test_a_recorder_that_has_died_is_not_waited_for() -> None:
    log = Log()
    log.marks.exchange(KEPT, 0)
    log.now = 11.0
    with pytest.raises(NoAnswer, match="flight recorder"):
        log.marks.mark(5.0, "")


def test_a_recorder_that_has_ended_takes_no_marks_from_then_on() -> None:
    log = Log()
    log.marks.exchange(KEPT, 0)
    log.marks.mark(5.0, "")
    assert log.marks.exchange(None, 0) == ()
    assert log.marks.kept is None
    with pytest.raises(NoAnswer, match="has ended"):
        log.marks.mark(5.0, "")


def test_the_log_says_once_what_became_of_each_moment() -> None:
    log = Log()
    for state in ("open", "open", "complete", "complete"):
        moment = Moment("a.mcap", (1,), ("jump",), state, 35.0, 900, 0, 5_000_000)  # type: ignore[arg-type]
        log.marks.exchange(RecorderState(30.0, 2, 30.0, 100, 1000, 20, 0, (moment,)), 0)
    failed = Moment("b.mcap", (2,), ("",), "failed", problem="b.mcap is cut short: no space")
    log.marks.exchange(RecorderState(30.0, 2, 30.0, 100, 1000, 20, 0, (failed,)), 0)
    assert log.lines == [
        ("info", "a moment is marked (jump): a.mcap"),
        ("info", "the marked moment is saved (jump): a.mcap, 35.0 s, 900 messages, 5.0 MB, 0 missing"),
        ("warning", "a marked moment is not saved: b.mcap is cut short: no space"),
    ]


@pytest.mark.parametrize(("text", "found"), [("30s", 30.0), ("500ms", 0.5), ("2min", 120.0), ("1.5", 1.5)])
def test_times_are_read_with_their_unit(text: str, found: float) -> None:
    assert seconds_of(text, "--keep") == found


@pytest.mark.parametrize("text", ["", "0s", "-1s", "2h", "nan", "61min", "1e3s"])
def test_what_is_no_time_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(InputError, match="write for example 30s"):
        seconds_of(text, "--keep")


def test_memory_is_read_with_its_unit() -> None:
    assert bytes_of("512MiB", "") == 512 << 20
    assert bytes_of("2GB", "") == 2 * 10**9
    for text in ("512", "10", "1kB", "lots"):
        with pytest.raises(InputError, match="512MiB"):
            bytes_of(text, "--keep-memory")
