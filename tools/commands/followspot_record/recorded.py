"""A recording as scripts hold it: `followspot.open_recording("show.mcap")`."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from followspot import Room
from followspot.closing import Closing
from followspot.errors import FollowspotError, did_you_mean
from followspot.graph.plan import Plan
from followspot.library.table import data_frame
from followspot.messages import Message
from followspot_record.embedded import offered_ports, plan_of_recording
from followspot_record.export import recorded_room, type_of
from followspot_record.recorded_rows import headings, rows
from followspot_recording.decoding import decoded
from followspot_recording.recording import Recording


class RecordedPort:
    """The messages of one port, in order: iterate over them, or take them as a table."""

    def __init__(self, recording: Recording, name: str) -> None:
        """Raises FollowspotError if the messages cannot be read by this version."""
        self.name = name
        self.type: type[Message] = type_of(recording.ports[name])
        self._recording = recording

    def __iter__(self) -> Iterator[Message]:
        """Messages; a Python warning at the end says if the file ends early or is damaged."""
        yield from decoded(self._recording, self.name, self.type)
        _warn_of(self._recording)

    def to_pandas(self) -> Any:
        """A DataFrame with a row for each row of each message. Raises ImportError without pandas."""
        room = recorded_room(self._recording)
        return data_frame(headings(self.type, room), (row for message in self for row in rows(message, room)))

    def __repr__(self) -> str:
        return f"<{self.name}: {self.type.__name__}>"


class RecordedRun(Closing):
    """A recorded run: its ports by name, the plan that was run and its room. Close it, or use ``with``."""

    def __init__(self, path: Path) -> None:
        """Raises FollowspotError if the file is no recording."""
        self._recording = Recording(path)
        self.path = path
        if not self._recording.ports:
            _warn_of(self._recording)

    @property
    def ports(self) -> tuple[str, ...]:
        """STAGE.PORT of all that was recorded."""
        return tuple(self._recording.ports)

    @property
    def plan(self) -> Plan:
        """The plan that was run. Raises FollowspotError if the file does not embed it."""
        return plan_of_recording(self._recording)

    @property
    def room(self) -> Room:
        """The room that it was recorded in; an empty one if the file does not say."""
        return recorded_room(self._recording)

    @property
    def problem(self) -> str:
        """Why the file ends early, as far as is known by now; empty if it is whole."""
        return self._recording.problem

    def __getitem__(self, port: str) -> RecordedPort:
        offered = {} if port in self._recording.ports else offered_ports(self._recording)
        behind = offered.get(port, (port,))
        if len(behind) > 1:
            raise FollowspotError(f'{self.path}: "{port}" stands for several ports: {", ".join(behind)}')
        if behind[0] not in self._recording.ports:
            remedy = did_you_mean(port, (*offered, *self.ports), "ports")
            raise FollowspotError(f'{self.path} has no port "{port}"; {remedy}')
        return RecordedPort(self._recording, behind[0])

    def __iter__(self) -> Iterator[str]:
        return iter(self.ports)

    def close(self) -> None:
        """Close the file."""
        self._recording.close()

    def __repr__(self) -> str:
        return f"<recording {self.path}: {', '.join(self.ports) or 'no ports'}>"


def _warn_of(recording: Recording) -> None:
    """Warn of what is missing in a file, as far as it is known by now."""
    if recording.problem:
        warnings.warn(recording.problem, stacklevel=3)
