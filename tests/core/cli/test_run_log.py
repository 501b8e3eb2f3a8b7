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
