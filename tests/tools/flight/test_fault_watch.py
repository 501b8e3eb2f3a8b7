"""Each fault of a run marks once, when it begins."""

from __future__ import annotations

from pathlib import Path

from followspot.library.handle import RunStatus, StageStatus, WorkerStatus
from followspot_record.flight.faults import FaultWatch
from followspot_record.flight.recorder import FlightRecorder


def status(*stages: StageStatus, phase: str = "running", age: float = 0.0) -> RunStatus:
    worker = WorkerStatus(name="main", phase=phase, stages=stages, age_s=age)  # type: ignore[arg-type]
    return RunStatus((worker,), (), 0, None)


def test_a_stage_that_fails_again_marks_again_and_one_that_stays_failed_does_not() -> None:
    watch = FaultWatch()
    well = StageStatus("fuse", "waiting")
    once = StageStatus("fuse", "waiting", restarts=1, error="Traceback\nValueError: no rows")
    twice = StageStatus("fuse", "waiting", restarts=2, error="Traceback\nValueError: no rows")
    told = [watch.new_faults(status(stage)) for stage in (well, once, once, twice)]
    assert told == [[], ["fuse: ValueError: no rows"], [], ["fuse: ValueError: no rows"]]


def test_a_silent_worker_marks_once_however_long_it_is_silent() -> None:
    watch = FaultWatch()
    silent = "worker main was last heard 2.0 s ago"
    told = [watch.new_faults(status(age=age)) for age in (0.1, 2.0, 3.0, 0.1, 2.0)]
    assert told == [[], [silent], [], [], [silent]]
    assert watch.new_faults(status(phase="absent", age=9.0)) == ["worker main is absent: last heard 9 s ago"]


def test_what_is_not_saved_is_told_once(tmp_path: Path) -> None:
    recorder = FlightRecorder(1.0, 100, lambda: None)  # type: ignore[arg-type, return-value]
    for _ in range(3):
        recorder.refuse("dropped > 0", "the disk is almost full")
    (moment,) = recorder.kept().moments
    assert (moment.state, moment.problem) == ("failed", "the disk is almost full")
