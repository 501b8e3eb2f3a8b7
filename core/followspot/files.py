"""Files that a user or a document names: opened so that nothing can hang, and read within bounds.

Only regular files are read, after links are followed: a pipe may block for ever, and a device may have no
end. The check examines the open descriptor, so that the file cannot be replaced between check and use. A
refusal is an OSError whose `strerror` has the reason, as for every other file that cannot be read.
"""

from __future__ import annotations

import errno
import os
import stat
from io import TextIOWrapper
from pathlib import Path
from typing import Any, BinaryIO

RUN_LOG = "log.jsonl"
"""The log in the output folder of each run."""
DOCUMENT = 1_000_000
"""Largest graph, room, placement, model, plugin, certificate or list of hosts, bytes."""
DATA = 64_000_000
"""Largest other file that is read at once: calibrations, weights, summaries; bytes."""
PICTURE = 256_000_000
"""Largest file of one picture, bytes."""
TABLE = 500_000_000
"""Largest table or log that is read row by row, and largest archive of arrays, bytes."""


def open_regular(path: str | Path, most: int | None = TABLE) -> BinaryIO:
    """Open a regular file of at most `most` bytes for reading; None: of any size. Raises OSError."""
    try:
        # Else a pipe without a writer would block, and a terminal would become the controlling one.
        descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    except ValueError:  # a NUL in the name
        raise OSError(errno.EINVAL, "this is not a file name", repr(str(path))) from None
    try:
        _check(os.fstat(descriptor), path, most)
        return os.fdopen(descriptor, "rb")
    except BaseException:
        os.close(descriptor)
        raise


def open_text(path: str | Path, most: int | None = TABLE, *, errors: str = "strict") -> TextIOWrapper:
    """Open a file as UTF-8 text, with or without a byte order mark; line ends stay. Raises OSError."""
    return TextIOWrapper(open_regular(path, most), "utf-8-sig", errors, newline="")


def read_bytes(path: str | Path, most: int = DATA) -> bytes:
    """The content of a regular file of at most `most` bytes. Raises OSError."""
    with open_regular(path, most) as file:
        data = file.read(most + 1)
    if len(data) > most:  # it has grown, or reports no size
        raise _too_large(path, most)
    return data


def read_text(path: str | Path, most: int = DATA, *, errors: str = "strict") -> str:
    """Read a file as UTF-8 text. Raises OSError, UnicodeDecodeError."""
    return read_bytes(path, most).decode("utf-8-sig", errors)


def require_regular(path: str | Path, most: int | None = None) -> None:
    """Raises OSError if `open_regular` would, for a file that another library opens by its name."""
    open_regular(path, most).close()


def removed(file: int) -> bool:
    """Whether an open file was removed, so that data written to it is lost. file: its descriptor."""
    return os.fstat(file).st_nlink == 0


def opencv_name(path: str | Path) -> Any:
    """The name of a file for OpenCV, whatever its folders are called.

    It is made of bytes, since OpenCV crashes on a name that is no UTF-8, and absolute, since FFmpeg takes
    what is before the colon of "12:30.mkv" for a protocol.
    """
    return os.fsencode(Path(path).absolute())


def _check(found: os.stat_result, path: str | Path, most: int | None) -> None:
    """Raises OSError if the file is not regular, or too large."""
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not stat.S_ISREG(found.st_mode):
        raise OSError(errno.EINVAL, "not a regular file but a device, a pipe or a socket", str(path))
    if most is not None and found.st_size > most:
        raise _too_large(path, most)


def _too_large(path: str | Path, most: int) -> OSError:
    return OSError(errno.EFBIG, f"larger than {most} bytes", str(path))


def unused_path(path: Path) -> Path:
    """The path, or the first numbered one beside it that is not taken."""
    unused, number = path, 1
    while unused.exists():
        number += 1
        unused = path.with_stem(f"{path.stem}-{number}")
    return unused
