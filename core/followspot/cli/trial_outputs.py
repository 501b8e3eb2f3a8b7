"""Whether two runs wrote the same, byte for byte."""

from __future__ import annotations

import filecmp
from collections.abc import Collection
from pathlib import Path


def same_outputs(one: Path, other: Path, beside: Collection[str] = ()) -> bool:
    """True if two output folders hold the same files with the same bytes, and at least one.

    beside: names of files that do not count, because they tell of the run and not of its results.
    """
    files = _files(one, beside)
    return bool(files) and files == _files(other, beside) and all(_same(one / f, other / f) for f in files)


def _files(folder: Path, beside: Collection[str]) -> set[Path]:
    found = (path for path in folder.rglob("*") if path.is_file() and path.name not in beside)
    return {path.relative_to(folder) for path in found}


def _same(one: Path, other: Path) -> bool:
    return filecmp.cmp(one, other, shallow=False)
