"""A text file that grows by whole lines below the run's output folder."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from followspot.errors import FollowspotError, InputError, Mistake

FLUSH_BYTES = 1 << 13


class TextFile:
    """Collects lines and writes them together, so that the file on disk ends with a whole line."""

    def __init__(self, folder: Path, name: Path) -> None:
        """Create the file, replacing an older one. Raises InputError for a name outside the folder."""
        self.path = below(folder, name)
        self.pending: list[str] = []
        self.size = 0
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self.file = self.path.open("wb", buffering=0)
        except OSError as error:
            raise FollowspotError(f"{self.path} cannot be written: {error.strerror}") from None

    def write(self, lines: Iterable[str]) -> None:
        """Add lines, each with its line end. Raises FollowspotError where the disk does not take them."""
        for line in lines:
            self.pending.append(line)
            self.size += len(line)
        if self.size >= FLUSH_BYTES:
            self.flush()

    def flush(self) -> None:
        """Hand all lines to the operating system. Raises FollowspotError."""
        data = memoryview("".join(self.pending).encode())
        self.pending.clear()
        self.size = 0
        try:
            while data:
                data = data[self.file.write(data) :]
        except OSError as error:
            remedy = "free space on the disk or choose another output folder"
            raise FollowspotError(f"{self.path} is not complete: {error.strerror}\n    {remedy}") from None

    def close(self) -> None:
        """Write what is left and close. Raises FollowspotError."""
        try:
            self.flush()
        finally:
            self.file.close()


def below(folder: Path, name: Path) -> Path:
    """The path of an output; it must stay below the run's output folder. Raises InputError."""
    path = (folder / name).resolve()
    if not path.is_relative_to(folder.resolve()) or path == folder.resolve():
        text = f"{name} lies outside the output folder {folder}"
        raise InputError([Mistake(None, text, "outputs are named relative to it; --out chooses another")])
    return path


def seconds(time: int) -> str:
    """Nanoseconds as exact decimal seconds."""
    whole, rest = divmod(time, 1_000_000_000)
    return f"{whole}.{rest:09d}"
