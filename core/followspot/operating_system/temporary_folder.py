"""Temporary folders that do not outlast their process for long, even if it is killed."""

from __future__ import annotations

import fcntl
import os
import shutil
import stat
import tempfile
import weakref
from contextlib import suppress
from pathlib import Path
from typing import IO

from followspot.closing import Closing

_OWNER = "owner"
"""The file of a folder that its process locks; the kernel unlocks it when the process ends."""


class TemporaryFolder(Closing):
    """A folder for this process alone.

    Making one removes those for the same purpose that killed processes of this user left.
    """

    def __init__(self, purpose: str) -> None:
        """purpose: a word for the folder's name. Raises OSError."""
        prefix = f"followspot-{purpose}-"
        _remove_abandoned(prefix)
        self.path = Path(tempfile.mkdtemp(prefix=prefix))
        new = self.path / f"{_OWNER}.new"
        owner = new.open("w")
        fcntl.flock(owner, fcntl.LOCK_EX)
        new.rename(self.path / _OWNER)  # locked from the moment that others see it
        self._remove = weakref.finalize(self, _remove, self.path, owner, os.getpid())

    def close(self) -> None:
        """Remove the folder; so does the end of the process, or that of the last reference."""
        self._remove()


def _remove(folder: Path, owner: IO[str], process: int) -> None:
    """Remove the folder of a process; a copy of the process that ends earlier removes nothing."""
    with owner:
        if os.getpid() == process:
            shutil.rmtree(folder, ignore_errors=True)


def _remove_abandoned(prefix: str) -> None:
    """Remove folders of this user whose owners have ended."""
    for folder in Path(tempfile.gettempdir()).glob(f"{prefix}*"):
        with suppress(OSError):  # it is in use, or goes at this moment
            found = folder.lstat()
            if not stat.S_ISDIR(found.st_mode) or found.st_uid != os.getuid():
                continue
            with (folder / _OWNER).open("r+") as owner:
                fcntl.flock(owner, fcntl.LOCK_EX | fcntl.LOCK_NB)
                shutil.rmtree(folder, ignore_errors=True)
