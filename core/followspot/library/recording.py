"""Recordings in scripts."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol, Self

from followspot.errors import FollowspotError
from followspot.graph.plan import Plan
from followspot.messages import Message
from followspot.plugins.loaded_hooks import load_hooks
from followspot.room import Room


class RecordedPort(Protocol):
    """The messages of one port, in order."""

    name: str
    type: type[Message]

    def __iter__(self) -> Iterator[Message]: ...

    def to_pandas(self) -> Any:
        """A DataFrame with a row for each row of each message. Raises ImportError without pandas."""


class Recording(Protocol):
    """A recorded run: its ports by name, the plan that was run and its room. Close it, or use ``with``."""

    path: Path

    @property
    def ports(self) -> tuple[str, ...]:
        """STAGE.PORT of every recorded port."""

    @property
    def plan(self) -> Plan:
        """The plan that was run. Raises FollowspotError if the file has none."""

    @property
    def room(self) -> Room:
        """The room of the run; an empty one if the file has none."""

    @property
    def problem(self) -> str:
        """Why the file ends early; empty if it is whole as far as it was read. A Python warning says it."""

    def __getitem__(self, port: str) -> RecordedPort:
        """A port by its name. Raises FollowspotError if it was not recorded."""

    def __iter__(self) -> Iterator[str]: ...

    def __enter__(self) -> Self: ...

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None: ...

    def close(self) -> None:
        """Close the file."""


def open_recording(path: str | Path) -> Recording:
    """Open a recording: ``recording["track.tracks"]`` iterates over messages; `to_pandas` makes a table.

    Raises FollowspotError if the file cannot be read, or no installed package reads its format.
    """
    readers = {reader.suffix: reader for reader in load_hooks().readers}
    reader = readers.get(Path(path).suffix)
    if reader is None:
        known = ", ".join(sorted(readers)) or "none"
        raise FollowspotError(f"nothing installed reads {path}; formats: {known}")
    try:
        recording: Recording = reader.open(Path(path))
    except ImportError as error:
        raise FollowspotError(f"{path} needs {error.name}: pip install 'followspot[recording]'") from error
    return recording
