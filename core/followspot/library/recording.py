"""Recordings in scripts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from followspot.errors import FollowspotError
from followspot.plugins.hooks import load_hooks


def open_recording(path: str | Path) -> Any:
    """Open a recording: ``recording["track.tracks"]`` iterates over messages; `to_pandas` makes a table.

    Raises FollowspotError if the file cannot be read, or no installed package reads its format.
    """
    readers = {reader.suffix: reader for reader in load_hooks().readers}
    reader = readers.get(Path(path).suffix)
    if reader is None:
        known = ", ".join(sorted(readers)) or "none"
        raise FollowspotError(f"nothing installed reads {path}; formats: {known}")
    try:
        return reader.open(Path(path))
    except ImportError as error:
        raise FollowspotError(f"{path} needs {error.name}: pip install 'followspot[recording]'") from error
