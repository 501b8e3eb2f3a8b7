"""NPZ files from elsewhere: named arrays, none of them pickled, and of limited size when unpacked, too."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from followspot.files import DATA, open_regular
from followspot.messages import Array


def read_arrays(path: Path, most: int = DATA) -> dict[str, Array]:
    """The arrays in a file of at most `most` bytes, packed and unpacked.

    Raises OSError if the file cannot be opened, ValueError if it is no archive of arrays.
    """
    with open_regular(path, most) as file:
        try:
            with zipfile.ZipFile(file) as archive:
                unpacked = sum(member.file_size for member in archive.infolist())
            if unpacked > most:
                raise ValueError(f"it unpacks to {unpacked} bytes, at most {most}")
            file.seek(0)
            with np.load(file, allow_pickle=False) as arrays:
                return {name: arrays[name] for name in arrays.files}
        except ValueError:
            raise
        except Exception as error:  # zip, its compressions and headers of NumPy have a dozen classes
            raise ValueError(f"it is no archive of arrays: {error}") from None
