"""The measured work of stages, from the report of an earlier run (`followspot run --json`)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import pydantic

from followspot.errors import InputError
from followspot.files import read_text
from followspot.valid_values.numbers import Count

_LARGEST = 64 << 20
"""Bytes of a report."""
MEASURE = "followspot run GRAPH --frames 200 --json > report.json"


class _Stage(pydantic.BaseModel):
    stage: str
    fired: Count
    busy_ms: Annotated[float, pydantic.Field(ge=0, le=1e12, allow_inf_nan=False)]


class _Worker(pydantic.BaseModel):
    stages: tuple[_Stage, ...]


class _Report(pydantic.BaseModel):
    frames: Annotated[int, pydantic.Field(ge=1)]
    workers: tuple[_Worker, ...]


@dataclass(frozen=True)
class Costs:
    """work: mean work of each stage instance on a frame set, ms; frames: of the run; name: of the report."""

    work: Mapping[str, float]
    frames: int
    name: str


def read_costs(path: Path) -> Costs:
    """The costs in a report. Raises InputError."""
    try:
        report = _Report.model_validate(json.loads(read_text(path, _LARGEST)))
    except OSError as error:
        raise InputError.of(f"cannot read {path}: {error.strerror}", MEASURE) from None
    except (ValueError, RecursionError):
        raise InputError.of(f"{path} is no report of a run with frames", MEASURE) from None
    stages = (stage for worker in report.workers for stage in worker.stages)
    return Costs({s.stage: s.busy_ms / report.frames for s in stages}, report.frames, path.name)
