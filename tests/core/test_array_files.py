"""Archives of arrays from elsewhere: whole, or an error that says why, whatever the bytes are."""

from __future__ import annotations

import io
import random
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from followspot.array_files import read_arrays


def archive(**members: bytes) -> bytes:
    """A zip file with these members."""
    kept = io.BytesIO()
    with zipfile.ZipFile(kept, "w") as file:
        for name, content in members.items():
            file.writestr(f"{name}.npy", content)
    return kept.getvalue()


def header(text: str) -> bytes:
    """A NumPy file of this header and no data."""
    padded = text.encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(padded).to_bytes(2, "little") + padded


def test_arrays_come_with_their_names(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez_compressed(path, one=np.arange(6.0).reshape(2, 3), two=np.array(7, np.int8))
    found = read_arrays(path)
    assert set(found) == {"one", "two"}
    np.testing.assert_array_equal(found["one"], [[0, 1, 2], [3, 4, 5]])
    assert found["two"].dtype == np.int8


@pytest.mark.parametrize(
    ("content", "cause"),
    [
        (b"", "no archive"),
        (b"PK\x03\x04 and no more", "no archive"),
        (archive(a=header("((((")), "."),
        (archive(a=header("{'descr': '<f8', 'fortran_order': False, 'shape': (500000000000,), }")), "."),
        (archive(a=header("{'descr': '|O', 'fortran_order': False, 'shape': (1,), }")), "allow_pickle"),
        (archive(a=b"\x00" * 2_000_000), "unpacks to 2000000 bytes, at most 1000000"),
    ],
)
def test_what_is_no_archive_is_a_value_error(tmp_path: Path, content: bytes, cause: str) -> None:
    path = tmp_path / "a.npz"
    if len(content) > 1_000_000:
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
            file.writestr("a.npy", b"\x00" * 2_000_000)
    else:
        path.write_bytes(content)
    with pytest.raises(ValueError, match=cause):
        read_arrays(path, 1_000_000)


def test_damage_anywhere_raises_nothing_but_a_value_error(tmp_path: Path) -> None:
    path, rng = tmp_path / "a.npz", random.Random(5)
    np.savez_compressed(path, a=np.arange(40.0), b=np.ones((3, 3), bool))
    whole = path.read_bytes()
    for _ in range(300):
        data = bytearray(whole)
        for _ in range(rng.randrange(1, 4)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        path.write_bytes(bytes(data[: rng.randrange(len(data) // 2, len(data) + 1)]))
        with suppress(ValueError):
            read_arrays(path)
