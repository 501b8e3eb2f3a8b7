"""The handle on a run with the types that it takes and returns, for commands and other programs."""

from __future__ import annotations

from followspot.control.clock_status import LIMIT_MS, ClockStatus
from followspot.control.dispatch import NoAnswer
from followspot.control.host import WorkerStatus
from followspot.control.process_identity import user_of
from followspot.control.stage_status import EdgeAge, PathStatus, StageState, StageStatus
from followspot.control.tapping import Tapping
from followspot.log.file import read_log
from followspot.log.record import LEVELS, LogRecord
from followspot.operator.connect import connected_run, run_here, runs_here
from followspot.operator.mark_queue import Mark, Moment, RecorderState
from followspot.operator.run_handle import RunHandle
from followspot.operator.run_status import OLD, RunStatus, is_old, is_stale
from followspot.worker.ledger import COUNTS, LOSSES, SOURCE_LOSSES, EdgeCount

__all__ = [
    "COUNTS",
    "LEVELS",
    "LIMIT_MS",
    "LOSSES",
    "OLD",
    "SOURCE_LOSSES",
    "ClockStatus",
    "EdgeAge",
    "EdgeCount",
    "LogRecord",
    "Mark",
    "Moment",
    "NoAnswer",
    "PathStatus",
    "RecorderState",
    "RunHandle",
    "RunStatus",
    "StageState",
    "StageStatus",
    "Tapping",
    "WorkerStatus",
    "connected_run",
    "is_old",
    "is_stale",
    "read_log",
    "run_here",
    "runs_here",
    "user_of",
]
