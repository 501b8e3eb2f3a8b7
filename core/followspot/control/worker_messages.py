"""What a worker tells its host, checked on the way in: one type for each kind of message."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

import pydantic

from followspot.control.dispatch import Request, Role, by_verb
from followspot.control.stage_status import PathStatus, StageStatus
from followspot.control.swap import ChangeStatus
from followspot.control.worker_report import WorkerReport
from followspot.log.record import LogRecord
from followspot.ranges import Count, Nanoseconds


class WorkerMessage(Request):
    """Base of these messages."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)


class Built(WorkerMessage):
    """The stages are there; `Ready` follows when they are set up."""


class Listening(WorkerMessage):
    """Where other sessions reach that of the worker."""

    locators: tuple[str, ...]


class Ready(WorkerMessage):
    """It waits for the start; expected: messages of its longest source, None if that is not known."""

    expected: Count | None


class Progress(WorkerMessage):
    """How far it is; see `followspot.worker.scheduler.Progress`."""

    fired: Count
    time: Nanoseconds


class Stages(WorkerMessage):
    """What its stages are doing."""

    stages: tuple[StageStatus, ...]
    paths: tuple[PathStatus, ...]


class State(WorkerMessage):
    """The checkpoint of a stage, as `state_to_data` gives it."""

    stage: str
    state: Any


class Change(WorkerMessage):
    """What became of a step of a change."""

    status: ChangeStatus


class Log(WorkerMessage):
    """Records since the last of these."""

    records: tuple[LogRecord, ...]


class Done(WorkerMessage):
    """It has ended."""

    report: WorkerReport


class Failed(WorkerMessage):
    """It could not be built."""

    error: Annotated[str, pydantic.Field(min_length=1)]


MESSAGES = by_verb((Built, Listening, Ready, Progress, Stages, State, Change, Log, Done, Failed))
