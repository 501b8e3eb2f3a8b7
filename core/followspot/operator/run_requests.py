"""Requests to a run's operator; `run_dispatcher` has their handlers."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar

import pydantic

from followspot.control.dispatch import Request, Role
from followspot.graph.provenance import SourceFiles
from followspot.operator.change_outcome import ChangeOutcome, MoveOutcome
from followspot.operator.mark_queue import Mark, RecorderState
from followspot.operator.run_status import RunStatus
from followspot.transport.zenoh.network import Network
from followspot.valid_values.numbers import Count


@dataclass(frozen=True)
class RunMetadata:
    """Origin and output folder of a run, and the endpoints by which other processes reach its hosts.

    out: its output folder on the operator's host, None if that is not this host; network: leads to its other
    hosts, None if it has none; source_files: of its graph, on the operator's host, None if it has none;
    began: when the operator prepared it, s since 1970, 0 if that is not known.
    """

    out: Path | None = None
    network: Network | None = None
    source_files: SourceFiles | None = None
    began: float = 0.0


class _OperatorRequest(Request):
    roles: ClassVar[tuple[Role, ...]] = ("operator",)


class GetPlan(_OperatorRequest):
    """The plan as it is now, as `plan_to_data` gives it."""

    answer: ClassVar[Any] = dict[str, Any]


class GetStatus(_OperatorRequest):
    """The status of the run, without the reports of ended workers."""

    answer: ClassVar[Any] = RunStatus


class GetRunMetadata(_OperatorRequest):
    """The metadata of the run: its output folder, the network that leads to its hosts, and its files."""

    answer: ClassVar[Any] = RunMetadata


class ChangeStages(_OperatorRequest):
    """Swap stages (`fuse=balls.mean`) and set parameters (`color.similarity=0.7`), all or none.

    folder: base of relative paths; fresh: whether replacements start without the state of the old stages.
    """

    words: tuple[str, ...]
    folder: Path = Path()
    fresh: bool = False
    answer: ClassVar[Any] = ChangeOutcome


class MoveStages(_OperatorRequest):
    """Move stages to another worker or host."""

    stages: tuple[str, ...]
    place: str
    answer: ClassVar[Any] = MoveOutcome


class MarkMoment(_OperatorRequest):
    """Save what the flight recorder holds and the next `after` seconds, s; the number of the mark."""

    after: Annotated[float, pydantic.Field(ge=0.0, le=600.0)] = 5.0
    note: Annotated[str, pydantic.Field(max_length=500)] = ""
    answer: ClassVar[Any] = int


class GetRecorderState(_OperatorRequest):
    """The state of the flight recorder; None if the run has none."""

    answer: ClassVar[Any] = RecorderState | None


class ExchangeMarks(_OperatorRequest):
    """The state of the flight recorder for the operator, None if it has ended; the marks after `taken`."""

    kept: RecorderState | None
    taken: Count
    answer: ClassVar[Any] = tuple[Mark, ...]
