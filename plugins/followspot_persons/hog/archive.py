"""Files of weights: named arrays, compressed, of limited size."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from followspot import Array
from followspot.files import DATA, open_regular

BROKEN = (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, zlib.error)
"""What reading a file raises that holds no weights."""


def arrays(path: Path) -> dict[str, Array]:
    """The arrays in a file, which may be compressed and has a limit unpacked, too. Raises one of `BROKEN`."""
    with open_regular(path, DATA) as file:
        if sum(member.file_size for member in zipfile.ZipFile(file).infolist()) > DATA:
            raise ValueError(f"more than {DATA} bytes unpacked")
        file.seek(0)
        return dict(np.load(file, allow_pickle=False))
