"""What a run shows of its log."""

from __future__ import annotations

from pathlib import Path

from followspot.cli.run_log import ShownLog
from followspot.log.record import Level, LogRecord


def shown(folder: Path, *, verbose: bool) -> list[str]:
    lines: list[str] = []
    log = ShownLog(folder, lines.append, verbose=verbose)
    levels: tuple[Level, ...] = ("info", "warning", "warning")
    for number, level in enumerate(levels):
        log.take(LogRecord(number, level, f"frame {number} is late", stage="color"))
    return lines


def test_warnings_of_one_kind_are_shown_once_and_all_records_on_request(tmp_path: Path) -> None:
    assert shown(tmp_path, verbose=False) == ["followspot: warning: color: frame 1 is late"]
    assert shown(tmp_path, verbose=True) == [
        "followspot: info: color: frame 0 is late",
        "followspot: warning: color: frame 1 is late",
        "followspot: warning: color: frame 2 is late",
    ]


def taken(folder: Path, *records: LogRecord) -> list[str]:
    lines: list[str] = []
    log = ShownLog(folder, lines.append)
    for record in records:
        log.take(record)
    return lines


def test_a_host_that_falls_silent_is_told_each_time_and_so_is_its_return(tmp_path: Path) -> None:
    away = LogRecord(0, "warning", "host pc-1 does not answer")
    back = LogRecord(0, "info", "host pc-1 is back")
    other = LogRecord(0, "warning", "host pc-2 does not answer")
    assert taken(tmp_path, away, back, other, away) == [
        "followspot: warning: host pc-1 does not answer",
        "followspot: info: host pc-1 is back",
        "followspot: warning: host pc-2 does not answer",
        "followspot: warning: host pc-1 does not answer",
    ]


def test_each_host_and_each_jump_of_its_clock_is_told(tmp_path: Path) -> None:
    clocks = [
        LogRecord(0, "warning", f"its clock is {offset} ms behind", host=host)
        for host, offset in (("pc-1", 7.0), ("pc-2", 7.5), ("pc-1", 2000.1))
    ]
    assert taken(tmp_path, *clocks) == [
        "followspot: warning: its clock is 7.0 ms behind [pc-1]",
        "followspot: warning: its clock is 7.5 ms behind [pc-2]",
        "followspot: warning: its clock is 2000.1 ms behind [pc-1]",
    ]


def test_a_worker_that_dies_without_end_does_not_fill_the_terminal(tmp_path: Path) -> None:
    died = LogRecord(0, "warning", "worker left died", worker="left")
    said = taken(tmp_path, *[died] * 1000)
    assert len(said) == 20
    assert "log.jsonl" in said[-1]
    assert "log.jsonl" not in said[-2]
