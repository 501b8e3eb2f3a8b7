"""One worker: a single thread that fires ready stages, and pulls sources when nothing else is ready.

Stages nearest to the sinks go first, so work in flight is finished before new work is taken in. Which stage
goes first never changes a result, for a firing depends on the streams alone.
"""

from __future__ import annotations

import select
import sys
import time
from collections import deque
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass
from functools import partial
from heapq import heappop, heappush
from operator import attrgetter

from followspot.errors import FollowspotError
from followspot.runtime.cell import Cell, StageError
from followspot.runtime.inlet import Inlet
from followspot.runtime.pace import Pace
from followspot.runtime.source import LiveCell, SourceCell
from followspot.runtime.team import teams
from followspot.transport.bell import Bell
from followspot.transport.edge import PortReader, PortWriter
from followspot.transport.token import END

_TURNS = 32
"""Firings between two looks at what other workers sent."""
_NAP_MS = 100
"""Longest sleep, ms; a wake-up that was missed costs no more."""
_SWITCH_INTERVAL = 0.0005
"""Seconds that one thread may keep the interpreter; live sources and Zenoh have threads of their own."""


_ALL = range(sys.maxsize)
"""Rows of all edges."""
_bound = attrgetter("bound")


class StuckError(FollowspotError):
    """No stage can fire, no source can yield, and yet the streams have not ended."""


@dataclass(frozen=True)
class Progress:
    """How far a worker, or a run, is."""

    fired: int
    """Firings of its sinks; of its sources where it has no sinks."""
    time: int
    """Newest capture time that a source sent, ns; -1 before the first."""
    faults: tuple[str, ...] = ()
    """What is absent or was not heard lately, a line each; of a run."""


class Worker:
    """Runs the cells of one process.

    cells: by rank; readers: inlets fed by other workers; writers: with the rank of the cell that owns each;
    pace: by which the sources wait.
    """

    def __init__(
        self,
        cells: Sequence[Cell],
        readers: Sequence[Inlet],
        writers: Sequence[tuple[PortWriter, int]],
        pace: Pace,
    ) -> None:
        self.cells = tuple(cells)
        self.sources = tuple(cell for cell in cells if isinstance(cell, SourceCell))
        self.live = tuple(cell for cell in self.sources if isinstance(cell, LiveCell))
        self.readers = tuple(readers)
        self.writers = tuple(writers)
        self.pace = pace
        self.regroup()
        self._ready: list[int] = []
        self._marked = [False] * len(cells)
        self._stopping = False
        self._errands: deque[Callable[[], None]] = deque()
        self._poll = select.poll()
        self._watched: dict[int, Callable[[], bool]] = {}
        self._bell = Bell()
        self._connect()

    def mark(self, rank: int) -> None:
        """The inputs or outputs of this cell changed; look at it."""
        if not self._marked[rank]:
            self._marked[rank] = True
            heappush(self._ready, -rank)

    def mark_waiting(self, cell: Cell) -> None:
        """Feedback came for this cell; look at it if that may be what it waits for."""
        if cell.done:
            self.mark(cell.rank)
            return
        for inlet in cell.join.members:
            if inlet.queue:
                self.mark(cell.rank)
                return

    def regroup(self) -> None:
        """Form the teams: stages that are alike now."""
        self.teams = teams(self.cells, self.mark)
        self._steps: list[Callable[[], None]] = [cell.step for cell in self.cells]
        for team in self.teams:
            for cell in team.cells:
                self._steps[cell.rank] = partial(team.step, cell)

    def fire_waiting(self) -> bool:
        """Fire members of a team without those that are not ready; False where none waits."""
        for team in self.teams:
            if team.waiting:
                team.fire()
                return True
        return False

    def between_firings(self, errand: Callable[[], None]) -> None:
        """Let the worker's thread do something as soon as no stage is at work. Safe from any thread."""
        self._errands.append(errand)
        self.ring()

    def watch(self, fd: int, callback: Callable[[], bool]) -> None:
        """Call back when the descriptor is readable, until the callback says that it is over."""
        self._watched[fd] = callback
        self._poll.register(fd, select.POLLIN)

    def adopt_reader(self, old: PortReader, new: PortReader) -> None:
        """The worker that wrote to `old` was started again, and writes to `new`."""
        inlet = next(inlet for inlet in self.readers if inlet.reader is old)
        self._unwatch(old.fileno())
        inlet.adopt(new)
        self.watch(new.fileno(), inlet.poll)

    def adopt_link(self, writer: PortWriter, fd: int) -> None:
        """The worker that read from `writer` was started again, and reads through `fd`."""
        rank = next(rank for known, rank in self.writers if known is writer)
        self.watch(fd, partial(self._credited, fd, writer, rank))
        for _, outlet in self.cells[rank].outlets:
            outlet.look()
            outlet.returned(writer)
        self.mark(rank)

    def give_up(self, rows: Container[int]) -> None:
        """Who is away at the other ends of these edges, or dies from now on, does not come back.

        rows: of the edges in the ledger.
        """
        for inlet in self.readers:
            if inlet.row in rows:
                inlet.after_loss = END
                inlet.poll()
        for cell in self.cells:
            for _, outlet in cell.outlets:
                outlet.patient &= not any(row in rows for group in outlet.rows for row in group)
            self.mark(cell.rank)

    def stop(self) -> None:
        """End all sources; what is in flight is still finished. Safe in signal handlers and threads."""
        self._stopping = True
        self.pace.end()
        self.ring()

    def ring(self) -> None:
        """Wake the worker from another thread."""
        self._bell.ring()

    def setup(self) -> None:
        """Set all stages up, in order. Raises StageError."""
        sys.setswitchinterval(_SWITCH_INTERVAL)
        if "cv2" in sys.modules:
            sys.modules["cv2"].setNumThreads(1)  # workers are the parallelism
        for cell in self.cells:
            cell.setup()

    def run(self) -> None:
        """Run to the end of all streams. Stages are closed however it ends. Raises StageError, StuckError."""
        problems: list[StageError] = []
        try:
            for source in self.live:
                source.start()
            for cell in self.cells:
                self.mark(cell.rank)
            while self._turn():
                pass
        finally:
            problems = self.close()
        if problems:
            raise problems[0]

    def close(self) -> list[StageError]:
        """Close stages and edges, all of them whatever one of them raises; what was raised."""
        problems = []
        for cell in self.cells:
            try:
                if isinstance(cell, LiveCell):
                    cell.stop()
                cell.close()
            except StageError as error:
                problems.append(error)
        for writer, _ in self.writers:
            writer.close()
        for cell in self.cells:
            for _, outlet in cell.outlets:
                outlet.look()  # what was on its way to readers that were cut off
        for inlet in self.readers:
            if inlet.reader is not None:
                inlet.reader.close()
        self._bell.close()
        return problems

    def progress(self) -> Progress:
        """How far the worker is."""
        counted = [cell.count.fired for cell in self.cells if cell.is_sink] or [
            s.yielded for s in self.sources
        ]
        return Progress(min(counted, default=0), max((s.bound for s in self.sources), default=-1))

    def expected(self) -> int | None:
        """Messages that the longest source will yield, None where none of them knows."""
        known = [n for n in (source.expected() for source in self.sources) if n is not None]
        return max(known, default=None)

    def _connect(self) -> None:
        self.watch(self._bell.fileno(), self._answer_bell)
        for inlet in self.readers:
            assert inlet.reader is not None
            self.watch(inlet.reader.fileno(), inlet.poll)
        for writer, rank in self.writers:
            for fd in writer.filenos():
                self.watch(fd, partial(self._credited, fd, writer, rank))
        for source in self.live:
            source.notify = self.ring

    def _turn(self) -> bool:
        """One round; False when everything has ended."""
        for _ in range(_TURNS):
            if not self._ready:
                break
            rank = -heappop(self._ready)
            self._marked[rank] = False
            self._steps[rank]()
        if len(self._watched) > 1:
            self._receive(0)
        while self._errands:
            self._errands.popleft()()
        if self._stopping:
            self._stop_sources()
        if self._ready or self._pull() or self.fire_waiting():
            return True
        if self._finished():
            return False
        self._wait()
        return True

    def _pull(self) -> bool:
        """Let the source that is furthest behind yield, and all that then are; False where none can."""
        candidates = [s for s in self.sources if not s.done]
        candidates.sort(key=_bound)
        reached = END
        for source in candidates:
            if source.bound >= reached:
                break
            source.blocked = not source.has_room()
            if not source.blocked and (source.pull() or source.done):
                reached = min(reached, source.bound)
        return reached < END

    def _finished(self) -> bool:
        """Whether all is done, sent, and received: feedback to a stage that has ended is still counted."""
        flushed = [writer.flush() for writer, _ in self.writers]
        received = all(inlet.bound == END for inlet in self.readers)
        return received and all(flushed) and all(cell.done for cell in self.cells)

    def _wait(self) -> None:
        """Sleep until another worker, a thread or a deadline has something for us."""
        if self._credit_came():
            return
        deadlines = [c.overdue_at for c in self.cells if c.overdue_at is not None and not c.done]
        if not (deadlines or self.readers or self.writers or self.live):
            raise StuckError(self._why_stuck())
        if not deadlines:
            self._receive(_NAP_MS)
            return
        left_ms = (min(deadlines) - time.monotonic()) * 1000
        self._receive(int(min(max(left_ms, 0), _NAP_MS)) + 1)
        for cell in self.cells:
            if cell.overdue_at is not None and cell.overdue_at <= time.monotonic():
                self.mark(cell.rank)

    def _credit_came(self) -> bool:
        """Ask readers to wake us when they take a message; whether one already did."""
        came = False
        for writer, rank in self.writers:
            cell = self.cells[rank]
            if cell.blocked:
                writer.want_credit()
                if cell.has_room():
                    self.mark(rank)
                    cell.blocked = False
                    came = True
        return came

    def _receive(self, timeout_ms: int) -> None:
        for fd, _ in self._poll.poll(timeout_ms):
            if self._watched[fd]():
                self._unwatch(fd)

    def _unwatch(self, fd: int) -> None:
        if self._watched.pop(fd, None) is not None:
            self._poll.unregister(fd)

    def _answer_bell(self) -> bool:
        self._bell.hush()
        return False

    def _credited(self, fd: int, writer: PortWriter, rank: int) -> bool:
        writer.drain()
        for _, outlet in self.cells[rank].outlets:
            outlet.look()
        self.mark(rank)
        return fd not in writer.filenos()

    def _stop_sources(self) -> None:
        self._stopping = False
        self.give_up(_ALL)
        for source in self.sources:
            if not source.done:
                source.stop()

    def _why_stuck(self) -> str:
        """Name the stages that wait, and for which edges."""
        lines = []
        for cell in self.cells:
            full = [i.name for _, o in cell.outlets for i in o.inlets if len(i.queue) >= i.depth]
            dry = [i.name for i in cell.join.members if not i.queue and i.bound != END]
            if not cell.done:
                lines.append(f"  {cell.name}: " + (f"full: {full}" if cell.blocked else f"waits for: {dry}"))
        return "the graph is stuck; raise `depth` of the full edges\n" + "\n".join(lines)
