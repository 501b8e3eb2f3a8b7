"""The file of a marked moment, written by a thread of its own."""

from __future__ import annotations

import shutil
import threading
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Literal

from followspot import Context, Message
from followspot.errors import FollowspotError
from followspot.frame_times import to_seconds
from followspot.graph.plan import Plan
from followspot.library.handle import Moment
from followspot.messages import InvalidMessage
from followspot.ports.firing import is_firings
from followspot.wire import unpack
from followspot_record.firings import facts_of_middle
from followspot_record.flight.kept_messages import KeptMessage
from followspot_record.record import target_of
from followspot_recording.sink import RecordingSink

RESERVE = 256 << 20
"""Bytes of the disk that are left free."""
_CHECKED = 16 << 20
"""Bytes after which the free space of the disk is checked again."""
_MOST_WAITING = 1.5
"""Share of the limit from which messages are lost."""
_Job = Callable[[], None]


class MomentFile:
    """A recording that is opened, written and completed in the order of these calls, none of which waits.

    It may be completed and go on after that, until it is closed. If more waits to be written than `limit`,
    bytes, viewers get no copies of messages; if half as much again waits, messages are lost, and counted.
    plan: of the run; types: of the messages, by port; files: embedded, by name.
    """

    def __init__(
        self,
        path: Path,
        plan: Plan,
        types: Mapping[str, type[Message]],
        files: Mapping[str, str],
        limit: int,
    ) -> None:
        self.path = path
        self._types = types
        self._limit = limit
        self._marks: list[int] = []
        self._notes: list[str] = []
        self._completed = 0
        """Number of marks at which the file was complete."""
        self._problem = ""
        self._messages = self._lost = self._waiting = 0
        self._begin = self._end = 0
        self._unchecked = 0
        """Bytes that were written since the last check."""
        self._sinks: dict[str, RecordingSink] = {}
        self._jobs: deque[tuple[_Job | None, int]] = deque()
        self._changed = threading.Condition()
        self._do(lambda: self._open(plan, files))
        self._thread = threading.Thread(target=self._work, name="moment", daemon=True)
        self._thread.start()

    @property
    def moment(self) -> Moment:
        """The present content of the file."""
        state = self._state  # first, for a complete file does not change any more
        size = self.path.stat().st_size if self.path.exists() else 0
        return Moment(
            str(self.path),
            tuple(self._marks),
            tuple(self._notes),
            state,
            to_seconds(self._end - self._begin),
            self._messages,
            self._lost,
            size,
            self._problem,
        )

    @property
    def _state(self) -> Literal["open", "complete", "failed"]:
        if self._problem:
            return "failed"
        return "complete" if self._completed == len(self._notes) else "open"

    @property
    def failed(self) -> bool:
        """Whether the disk did not take it."""
        return bool(self._problem)

    @property
    def gone(self) -> bool:
        """Whether the file was removed or moved since it was complete."""
        return self._completed > 0 and not self.path.exists()

    def mark(self, number: int, note: str, time: int) -> None:
        """Note a mark; number: of a user's, 0 for others; time: newest capture time, ns."""
        self._marks += [number] if number else []
        self._notes.append(note)
        name = f"mark {len(self._notes)}"
        self._do(lambda: self._note(name, note, time))

    def put(self, message: KeptMessage, *, held: bool) -> None:
        """Write a message, or count it as lost if too much waits. held: whether it stays in memory anyway."""
        self._lost += message.missing
        if not held and self._waiting > _MOST_WAITING * self._limit:
            self._lost += 1
            return
        self._do(lambda: self._write(message), len(message.packed))

    def complete(self) -> None:
        """Complete the file: other programs can open it."""
        count = len(self._notes)
        self._do(lambda: self._complete(count))

    def close(self) -> None:
        """Complete and close the file, and wait for that."""
        self.complete()
        with self._changed:
            self._jobs.append((None, 0))
            self._changed.notify()
        self._thread.join()

    def _do(self, job: _Job, size: int = 0) -> None:
        """Do a job after the earlier ones. size: bytes that wait for that."""
        with self._changed:
            self._waiting += size
            self._jobs.append((job, size))
            self._changed.notify()

    def _work(self) -> None:
        while (job := self._next()) is not None:
            if self._problem:
                continue
            try:
                job()
            except (FollowspotError, InvalidMessage, OSError) as error:
                self._problem = str(error)
        for sink in self._sinks.values():
            try:
                sink.close()
            except FollowspotError as error:
                self._problem = self._problem or str(error)

    def _next(self) -> _Job | None:
        with self._changed:
            while not self._jobs:
                self._changed.wait()
            job, size = self._jobs.popleft()
            self._waiting -= size
            return job

    def _open(self, plan: Plan, files: Mapping[str, str]) -> None:
        self._check_space()
        known = tuple(self._types)
        names = [port for port in known if not is_firings(port)]
        target = target_of(plan, names, Path(self.path.name), files=files)
        self._target = replace(target, metadata={**target.metadata, **facts_of_middle(plan)})
        self._context = Context(room=plan.room, out=self.path.parent)
        for port in known:
            self._sink(port)

    def _sink(self, port: str) -> RecordingSink:
        """The sink of a port, also of one that has come while the file is open."""
        sink = self._sinks.get(port)
        if sink is None:
            params = self._target.sink_params(port, first=not self._sinks)
            sink = self._sinks[port] = RecordingSink(self._context, **params)
            sink.setup()
        return sink

    def _check_space(self) -> None:
        """Raises FollowspotError if the disk is nearly full: others write there, too."""
        if shutil.disk_usage(self.path.parent).free < RESERVE:
            text = f"less than {RESERVE >> 20} MiB is free on the disk of {self.path.parent}"
            raise FollowspotError(f"{text}; that is left to what the run writes")

    def _write(self, message: KeptMessage) -> None:
        self._unchecked += len(message.packed)
        if self._unchecked > _CHECKED:
            self._unchecked = 0
            self._check_space()
        found = unpack(message.packed, self._types[message.port])
        if isinstance(found, Message):
            self._sink(message.port).put(found, shown=self._waiting <= self._limit)
            self._begin = min(self._begin, message.time) if self._messages else message.time
            self._end = max(self._end, message.time) if self._messages else message.time
            self._messages += not is_firings(message.port)

    def _note(self, name: str, note: str, time: int) -> None:
        next(iter(self._sinks.values())).note(name, f"marked: {note}" if note else "marked", time)

    def _complete(self, count: int) -> None:
        next(iter(self._sinks.values())).complete()
        self._completed = count
