"""What a worker may say to its host, checked on the way in: one type for each kind of message."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any

import pydantic

from followspot.control.stage_status import PathStatus, StageStatus
from followspot.control.swap import ChangeStatus
from followspot.control.worker_report import WorkerReport
from followspot.log.record import LogRecord
from followspot.ranges import Count, Nanoseconds


@dataclass(frozen=True)
class Built:
    """The stages are there; `Ready` follows when they are set up."""


@dataclass(frozen=True)
class Listening:
    """Where other sessions reach that of the worker."""

    locators: tuple[str, ...]


@dataclass(frozen=True)
class Ready:
    """It waits for the start; expected: messages of its longest source, None where nobody knows."""

    expected: Count | None


@dataclass(frozen=True)
class Progress:
    """How far it is; see `followspot.worker.scheduler.Progress`."""

    fired: Count
    time: Nanoseconds


@dataclass(frozen=True)
class Stages:
    """What its stages are doing."""

    stages: tuple[StageStatus, ...]
    paths: tuple[PathStatus, ...]


@dataclass(frozen=True)
class State:
    """What a successor of a stage would need to carry on, as `state_to_data` gives it."""

    stage: str
    state: Any


@dataclass(frozen=True)
class Change:
    """What became of a step of a change."""

    status: ChangeStatus


@dataclass(frozen=True)
class Log:
    """Records since the last of these."""

    records: tuple[LogRecord, ...]


@dataclass(frozen=True)
class Done:
    """It has ended."""

    report: WorkerReport


@dataclass(frozen=True)
class Failed:
    """It could not be built."""

    error: Annotated[str, pydantic.Field(min_length=1)]


Said = Built | Listening | Ready | Progress | Stages | State | Change | Log | Done | Failed
_KINDS: Mapping[str, type[Any]] = {kind.__name__.lower(): kind for kind in Said.__args__}


def said(message: Mapping[str, Any]) -> Said:
    """A message of the control channel. Raises ValueError where no worker says so."""
    kind = message["kind"]
    if kind not in _KINDS:
        raise ValueError(f"a message of kind {kind[:80]!r}")
    found: Said = _adapter(kind).validate_python(message)
    return found


@cache
def _adapter(kind: str) -> pydantic.TypeAdapter[Any]:
    """Made when it is needed first: it takes its time."""
    return pydantic.TypeAdapter(_KINDS[kind])
