"""The table of data sets: what each is, under which licence, and the files that may be fetched."""

from __future__ import annotations

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urljoin

HERE = Path(__file__).parent
PLAIN = re.compile(r"\w[\w.-]*(/\w[\w.-]*)*", re.ASCII)
"""A path below a folder: no part of it is empty, `..`, or begins with a dot."""


@dataclass(frozen=True)
class RemoteFile:
    """A file of a data set. path: below the folder of the set; size: bytes."""

    path: str
    url: str
    size: int
    sha256: str

    def __post_init__(self) -> None:
        if not PLAIN.fullmatch(self.path):
            raise ValueError(f"{self.path!r} is no path below a folder")


@dataclass(frozen=True)
class DataSet:
    """One data set. by_hand: why it is not fetched; empty if it is."""

    name: str
    about: str
    licence: str
    origin: str
    files: tuple[RemoteFile, ...]
    by_hand: str

    def missing(self, folder: Path) -> list[RemoteFile]:
        """The files that `folder`/NAME does not contain. Their contents are not looked at."""
        return [file for file in self.files if not (folder / self.name / file.path).is_file()]


def data_sets(folder: Path = HERE) -> dict[str, DataSet]:
    """All data sets of `folder`/table.toml, by name. Raises ValueError, OSError, KeyError if it is wrong."""
    table = tomllib.loads((folder / "table.toml").read_text(encoding="utf-8"))
    return {name: _data_set(name, entry, folder) for name, entry in table.items()}


def _data_set(name: str, entry: dict[str, str], folder: Path) -> DataSet:
    lines: list[str] = []
    if "url" in entry:
        lines = (folder / "files" / f"{name}.txt").read_text(encoding="utf-8").splitlines()
    files = tuple(_remote_file(line.split(), entry.get("url", "")) for line in lines)
    return DataSet(name, entry["about"], entry["licence"], entry["origin"], files, entry.get("by_hand", ""))


def _remote_file(words: list[str], url: str) -> RemoteFile:
    sha256, size, path, *elsewhere = words
    return RemoteFile(path, urljoin(url, elsewhere[0] if elsewhere else path), int(size), sha256)
