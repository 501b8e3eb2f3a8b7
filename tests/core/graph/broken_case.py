"""A graph, room or placement file with a mistake; ¦ marks where the mistake must be reported."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Broken:
    """In `file`, `old` became `new`; `text` and `remedy` are parts of what must be said."""

    file: str
    old: str
    new: str
    text: str
    remedy: str = ""
