"""One record of a run's log."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cache
from typing import Annotated, Any, Literal

import pydantic

from followspot.errors import printable_lines
from followspot.valid_values.numbers import Last, Nanoseconds

Level = Literal["info", "warning", "error"]
LEVELS: tuple[Level, ...] = ("info", "warning", "error")
"""In order of severity."""
MAX_TEXT = 4000
"""Longest text, characters."""
PAGE = 500
"""Most records of one page."""
_MAX_NAME = 300
Said = Annotated[str, pydantic.AfterValidator(printable_lines)]
"""What others say, of several lines: control characters become escapes, for they could rewrite a terminal."""


@dataclass(frozen=True)
class LogRecord:
    """A text with its origin; host, worker and stage are "" if it concerns none.

    time: ns since 1970 by the clock of its host; stage: its name, or that of another Python logger.
    """

    time: Nanoseconds
    level: Level
    text: Annotated[Said, pydantic.Field(max_length=MAX_TEXT)]
    host: Annotated[str, pydantic.Field(max_length=_MAX_NAME)] = ""
    worker: Annotated[str, pydantic.Field(max_length=_MAX_NAME)] = ""
    stage: Annotated[str, pydantic.Field(max_length=_MAX_NAME)] = ""

    def to_data(self) -> dict[str, Any]:
        """JSON types."""
        return asdict(self)


@dataclass(frozen=True)
class LogPage:
    """Records in order of arrival, and the number of the last; -1 before the first."""

    records: Annotated[tuple[LogRecord, ...], pydantic.Field(max_length=PAGE)] = ()
    last: Last = -1


def records_from_data(data: Any) -> Sequence[LogRecord]:
    """Records that came from elsewhere. Raises ValueError."""
    return _records().validate_python(data)


@cache
def _records() -> pydantic.TypeAdapter[list[LogRecord]]:
    """Made when it is needed: workers only send."""
    return pydantic.TypeAdapter(list[LogRecord])
