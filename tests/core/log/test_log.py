"""The log of a run: bounded everywhere, complete where there is room, and read as far as it is good."""

from __future__ import annotations

import logging
import threading
from pathlib import Path

import pydantic
import pytest
from tests.full_disk import full_disk

from followspot.context import Context
from followspot.control.dispatch import Request, answer_from_wire, verb
from followspot.control.observation import GetLog
from followspot.control.worker_report import WorkerReport
from followspot.errors import InputError
from followspot.log.collector import BURST, PER_SECOND, LogCollector, collecting
from followspot.log.file import LogFile, read_log
from followspot.log.merged import MergedLog
from followspot.log.record import MAX_TEXT, LogRecord, records_from_data
from followspot.log.run_log import KEPT, RunLog
from followspot.messages import Header
from followspot.stage import Stage
from followspot.worker.main import WorkerMain
from followspot.worker.reporting.report import Warnings
from followspot.worker.runners.error_policy import StageError


def record(text: str) -> LogRecord:
    return LogRecord(1, "info", text)


def texts(log: RunLog, after: int = -1) -> list[str]:
    return [record.text for record in log.after(after).records]


def test_what_others_sent_moves_no_cursor_and_colours_nothing() -> None:
    collector, warnings = LogCollector("left"), Warnings()
    sent = "sensor says \x1b[2J\x1b]0;title\x07 and \x9b31m\nover two lines"
    collector.say("warning", "imu", sent)
    warnings.add("imu", sent)
    for text in (collector.take()[0].text, warnings.last["imu"], *warnings.lines()):
        assert r"sensor says \x1b[2J\x1b]0;title\x07 and \x9b31m" in text
        assert text.count("\n") == 1
        assert all(character.isprintable() or character == "\n" for character in text)


def test_what_other_hosts_sent_moves_no_cursor_either() -> None:
    sent, told = "sensor says \x1b[2J\nover two lines", "sensor says \\x1b[2J\nover two lines"
    (record,) = records_from_data([{"time": 1, "level": "error", "text": sent}])
    report = {"worker": "a", "frames": 0, "warnings": [sent], "error": sent}
    took = pydantic.TypeAdapter(WorkerReport).validate_python(report)
    assert (record.text, *took.warnings, took.error) == (told, told, told)


def test_an_error_of_a_stage_moves_no_cursor_and_is_told_in_part_if_it_is_huge() -> None:
    """Else the report of the run is longer than a message between processes may be."""
    text = str(
        StageError("read", Header("camera", 7, 8), ValueError("bad \x1b[2J bytes: " + "x" * 1_000_000))
    )
    assert text.startswith(r"stage read failed at camera#7, 0.000000 s: ValueError: bad \x1b[2J bytes: xxx")
    assert len(text) < 20_000
    assert all(character.isprintable() or character == "\n" for character in text)


def test_what_stages_and_libraries_say_is_collected_while_the_block_runs() -> None:
    collector = LogCollector("left")
    stage = Stage(Context("color/cam0"))
    with collecting(collector):
        stage.log.info("dark, %d lux", 3)
        stage.log.debug("nobody asked")
        try:
            raise OSError("gone")
        except OSError:
            logging.getLogger("library").exception("no file")
        wrong = {"name": "library", "msg": "%d", "args": ("none",), "levelno": logging.WARNING}
        collector.emit(logging.makeLogRecord(wrong))
    stage.log.warning("too late")
    said = collector.take()
    assert [(r.level, r.worker, r.stage) for r in said] == [
        ("info", "left", "color/cam0"),
        ("error", "left", "library"),
        ("warning", "left", "library"),
    ]
    assert said[0].text == "dark, 3 lux"
    assert said[1].text.endswith("OSError: gone")
    assert "cannot be formatted" in said[2].text
    assert collector.take() == []


def test_a_stage_that_never_stops_talking_is_counted_and_not_believed() -> None:
    now = [0.0]
    collector = LogCollector("left", lambda: now[0])
    for _ in range(3):
        for _ in range(2 * BURST):
            collector.say("warning", "fuse", "x" * 2 * MAX_TEXT)
    said = collector.take()
    assert len(said) == BURST + 1
    assert len(said[0].text) == MAX_TEXT
    assert said[-1].text == f"{5 * BURST} more records were left out"
    now[0] = 2.0
    for _ in range(2 * BURST):
        collector.say("warning", "fuse", "still")
    assert len(collector.take()) == 2 * PER_SECOND + 1


def test_what_another_thread_has_taken_is_told_before_the_last_word() -> None:
    told: list[str] = []
    taken, ended = threading.Event(), threading.Event()

    class Channel:
        def send(self, request: Request) -> None:
            taken.set()
            ended.wait(0.2)  # held up, while the worker comes to its end
            told.append(verb(type(request)))

    main = WorkerMain(Channel())  # type: ignore[arg-type]
    main.log.say("error", "fuse", "broken")
    telling = threading.Thread(target=main.reporter.send_log)
    telling.start()
    assert taken.wait(60)
    main.reporter.send_log()
    told.append("done")
    ended.set()
    telling.join()
    assert told == ["log", "done"]


def test_only_the_newest_records_are_kept_and_each_is_read_once() -> None:
    log = RunLog()
    log.add(*(record(str(number)) for number in range(KEPT + 100)))
    found: list[str] = []
    last = -1
    while len(page := texts(log, last)):
        found += page
        last = log.after(last).last
    assert found == [str(number) for number in range(100, KEPT + 100)]
    assert log.after(10**9).records == ()
    assert log.after(-(10**9)).records[0].text == "100"


def test_the_logs_of_hosts_become_one() -> None:
    heard: list[str] = []
    hosts = [Kept(RunLog()), Kept(RunLog())]
    merged = MergedLog(hosts, lambda record: heard.append(record.text))
    for number in range(1200):  # more than fits on a page
        hosts[number % 2].log.add(record(str(number)))
    merged.gather()
    merged.gather()
    assert sorted(map(int, heard)) == list(range(1200))
    assert merged.last == 1199


class Kept:
    def __init__(self, log: RunLog) -> None:
        self.log = log


def test_a_log_that_was_torn_is_read_as_far_as_it_is_good(tmp_path: Path) -> None:
    file = LogFile(tmp_path)
    for text in ("one", "zwei\nüber"):
        file.write(record(text))
    with file.path.open("a") as torn:
        torn.write('{"time": 1, "lev')
    assert [r.text for r in read_log(tmp_path)] == ["one", "zwei\nüber"]
    with file.path.open("a") as torn:
        torn.write("\n")
    with pytest.raises(InputError, match=r"log\.jsonl:3: not a record"):
        list(read_log(tmp_path))
    LogFile(tmp_path).write(record("anew"))
    LogFile(tmp_path, again=True).write(record("more"))
    assert [r.text for r in read_log(tmp_path)] == ["anew", "more"]


def test_a_full_disk_ends_the_file_and_not_the_run() -> None:
    file = LogFile(Path("/dev/null"))  # a folder that is none
    file.write(record("one"))
    file.write(record("two"))
    with pytest.raises(InputError, match="output folder of a run"):
        list(read_log(Path("/dev/null")))


def test_a_disk_that_becomes_full_leaves_whole_records_and_the_next_log_goes_on(tmp_path: Path) -> None:
    """An operator that takes the run over writes the next one, when the disk has room again."""
    LogFile(tmp_path).write(record("one"))
    size = (tmp_path / "log.jsonl").stat().st_size
    with full_disk(size + 10):
        file = LogFile(tmp_path, again=True)
        for text in ("two", "three"):
            file.write(record(text))
    assert (tmp_path / "log.jsonl").stat().st_size == size
    LogFile(tmp_path, again=True).write(record("four"))
    assert [r.text for r in read_log(tmp_path)] == ["one", "four"]


@pytest.mark.parametrize(
    "wrong",
    [
        {"level": "loud"},
        {"text": "x" * (MAX_TEXT + 1)},
        {"stage": "x" * 1000},
        {"time": "now"},
        {"text": 5},
    ],
)
def test_records_from_other_hosts_are_checked(wrong: dict[str, object]) -> None:
    good = record("one").to_data()
    assert records_from_data([good]) == [record("one")]
    with pytest.raises(ValueError, match="validation error"):
        answer_from_wire(GetLog, {"records": [good | wrong], "last": 0})
