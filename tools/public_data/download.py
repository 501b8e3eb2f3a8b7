"""Downloads that go on where they ended, and are only kept if they are what was asked for."""

from __future__ import annotations

import hashlib
import urllib.error
import urllib.request
from http.client import HTTPException
from pathlib import Path
from typing import IO

from public_data.table import RemoteFile

BLOCK = 1 << 20
TIMEOUT = 60.0
"""Of a server that says nothing, s."""
PARTIAL = 206


class DownloadError(Exception):
    """Says which file cannot be had, and why."""


def download(file: RemoteFile, path: Path) -> None:
    """Fetch a file to `path`; what has come already stays in `path`.part for the next attempt.

    Raises DownloadError if the server cannot be reached, and for other bytes than those that are known: they
    are removed. OSError if `path` cannot be written.
    """
    part = path.with_name(path.name + ".part")
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        _receive(file, part)
    except (urllib.error.URLError, HTTPException, TimeoutError, ConnectionError) as error:
        raise DownloadError(f"{file.url}: {error}; what has come is kept: try again") from None
    if part.stat().st_size != file.size or _sha256(part) != file.sha256:
        part.unlink()
        raise DownloadError(f"{file.url} is another file than the one that is known: its SHA-256 differs")
    part.replace(path)


def _receive(file: RemoteFile, part: Path) -> None:
    """Append to `part` what is missing of the file, and at most one byte more than it has."""
    have = part.stat().st_size if part.exists() else 0
    if have == file.size:
        return
    headers = {"Range": f"bytes={have}-"} if 0 < have < file.size else {}
    request = urllib.request.Request(file.url, headers=headers)
    with urllib.request.urlopen(request, timeout=TIMEOUT) as answer:
        goes_on = headers and answer.status == PARTIAL
        with part.open("ab" if goes_on else "wb") as out:
            _copy(answer, out, file.size + 1 - (have if goes_on else 0))
    if part.stat().st_size < file.size:
        raise ConnectionError("the connection ended too early")


def _copy(source: IO[bytes], out: IO[bytes], limit: int) -> None:
    while limit > 0 and (block := source.read(min(BLOCK, limit))):
        out.write(block)
        limit -= len(block)


def _sha256(path: Path) -> str:
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()
