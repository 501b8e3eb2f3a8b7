"""Messages from a worker to its host, validated on arrival."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar

import pydantic

from followspot.control.dispatch import Request, Role
from followspot.control.stage_status import PathStatus, StageStatus
from followspot.control.swap import ChangeStatus
from followspot.control.worker_report import WorkerReport
from followspot.log.record import LogRecord, Said
from followspot.valid_values.numbers import Count, Nanoseconds


class WorkerMessage(Request):
    """Base of all messages from a worker."""

    roles: ClassVar[tuple[Role, ...]] = ("host",)


class Built(WorkerMessage):
    """The stages are built; `Ready` follows when they are set up."""


class Listening(WorkerMessage):
    """The locators of the worker's Zenoh session."""

    locators: tuple[str, ...]


class Ready(WorkerMessage):
    """The worker waits for `StartRun`.

    expected: messages of its longest source, None if unknown; last_times: see `WorkerStatus`.
    """

    expected: Count | None
    last_times: dict[str, Nanoseconds]


class Progress(WorkerMessage):
    """The worker's progress; see `followspot.control.progress.Progress`."""

    fired: Count
    time: Nanoseconds


class Stages(WorkerMessage):
    """The statuses of the worker's stages and paths."""

    stages: tuple[StageStatus, ...]
    paths: tuple[PathStatus, ...]


class StageCheckpoint(WorkerMessage):
    """The checkpoint of a stage, as `state_to_data` gives it."""

    stage: str
    state: Any


class ChangeAnswer(WorkerMessage):
    """The worker's answer to a step of a change."""

    status: ChangeStatus


class Log(WorkerMessage):
    """The log records since the last of these messages."""

    records: tuple[LogRecord, ...]


class Done(WorkerMessage):
    """The worker has ended."""

    report: WorkerReport


class Failed(WorkerMessage):
    """The worker could not be built; error: why."""

    error: Annotated[Said, pydantic.Field(min_length=1)]
