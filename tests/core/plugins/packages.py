"""Installed packages that exist for one test."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

STAGE = """\
from followspot import Message, Source, Stage


class Note(Message):
    pitch: float


class Piano(Stage):
    def process(self) -> Source[Note]:
        yield from ()
"""


def install(
    site: Path,
    name: str,
    entries: str,
    *,
    version: str = "1.0",
    requires: Sequence[str] = (),
    modules: dict[str, str] | None = None,
) -> None:
    """Put a distribution into a folder, as pip would. entries: text of its entry_points.txt."""
    info = site / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir(parents=True)
    needs = "".join(f"Requires-Dist: {text}\n" for text in requires)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n{needs}")
    (info / "entry_points.txt").write_text(entries)
    for module, text in (modules or {}).items():
        path = site / module
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
