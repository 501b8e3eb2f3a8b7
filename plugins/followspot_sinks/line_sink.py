"""A text file that grows by whole lines below the run's output folder."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from contextlib import suppress
from io import SEEK_END, FileIO
from itertools import accumulate
from os import pread
from pathlib import Path

from followspot import Stage
from followspot.errors import FollowspotError, InputError, Mistake
from followspot.files import removed
from followspot.operating_system.limits import limit_remedy

FLUSH_BYTES = 1 << 13
"""Size of the lines that are written together, B."""


class LineSink(Stage):
    """Base of sinks with a parameter `path`: collects lines and writes them together.

    The file on disk ends with a whole line at any time, so that it is valid also after a kill.
    """

    join_tolerance = 0.0
    file: FileIO | None = None

    def setup(self) -> None:
        """Create the file, or open that which the run began. Raises FollowspotError if that is not possible.

        A file of an earlier run is replaced.
        """
        path = below(self.context.out, self.params.path)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self.file = FileIO(path, "a+" if self.context.resumed else "w")
        except OSError as error:
            raise FollowspotError(f"{path} cannot be written: {error.strerror}") from None
        self.due = False
        self.pending: list[bytes] = []
        self.pending_bytes = 0

    def begin(self, line: str) -> None:
        """Write the first line of an empty file. Raises FollowspotError if the file begins otherwise."""
        if self.file is None or not self.context.resumed or self.file.tell() == 0:
            self.write([line])
        elif pread(self.file.fileno(), len(line.encode()), 0) != line.encode():
            raise FollowspotError(f"{self.params.path} has other columns\n    give the sink another file")

    def write(self, lines: Iterable[str]) -> None:
        """Add lines, each with its line end. Raises FollowspotError if the disk does not take them."""
        for line in map(str.encode, lines):
            self.pending.append(line)
            self.pending_bytes += len(line)
        if self.due or self.pending_bytes >= FLUSH_BYTES:
            self.flush()

    def state(self) -> None:
        """There is none; the next lines are flushed, so that a worker that dies loses a second of them."""
        self.due = True

    def flush(self) -> None:
        """Hand all lines to the operating system. Raises FollowspotError."""
        if self.file is None:
            return
        lines, self.pending = self.pending, []
        self.due, self.pending_bytes = False, 0
        if removed(self.file.fileno()):
            raise FollowspotError(f"{self.file.name} was removed while the run wrote it: its lines are lost")
        data, done = memoryview(b"".join(lines)), 0
        try:
            while done < len(data):
                done += self.file.write(data[done:])
        except OSError as error:
            ends = list(accumulate(map(len, lines)))
            whole = bisect_right(ends, done)
            self._take_back(done - (ends[whole - 1] if whole else 0))
            text = f"{self.file.name} is cut short: {error.strerror}; {len(lines) - whole} lines are lost"
            remedy = limit_remedy(error, "free space on the disk or choose another output folder")
            raise FollowspotError(f"{text}\n    {remedy}") from None

    def _take_back(self, count: int) -> None:
        """Let the file end before its last bytes, which are half a line. A device cannot be shortened."""
        if self.file is not None and count:
            with suppress(OSError):
                self.file.truncate(self.file.seek(-count, SEEK_END))

    def close(self) -> None:
        """Write the remaining lines and close. Raises FollowspotError."""
        if self.file is not None:
            try:
                self.flush()
            finally:
                self.file.close()
                self.file = None


def below(folder: Path, name: Path) -> Path:
    """The path of an output, which must stay below the run's output folder. Raises InputError."""
    root = folder.resolve()
    path = (root / name).resolve()
    if root not in path.parents:
        text = f"{name} lies outside the output folder {folder}"
        raise InputError([Mistake(None, text, "outputs are named relative to it; --out chooses another")])
    return path


def seconds(time: int) -> str:
    """Nanoseconds as exact decimal seconds."""
    whole, rest = divmod(abs(time), 1_000_000_000)
    return f"{'-' if time < 0 else ''}{whole}.{rest:09d}"
