"""The interface of packages that score a run against the ground truth of its room.

A package offers a `followspot.plugins.hooks.Scorer` for each kind of ground truth.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, Protocol

from followspot.messages import Message
from followspot.room import Room


class Score(Protocol):
    """The scores of everything that the truth names. Its text is a table for people."""

    noun: str
    """Kind of the objects that are scored: "target", "person"."""

    def to_data(self) -> dict[str, dict[str, Any]]:
        """The figures by name in JSON types; what cannot be told is None."""


class Scoring(Protocol):
    """Compares messages of one type, in a table that a sink wrote, with ground truth of one type."""

    messages: type[Message]
    truth: type[Message]

    def read_truth(self, messages: Iterable[Any], room: Room) -> Any:
        """The ground truth, from one message for each frame."""

    def score(self, file: Path, truth: Any, room: Room) -> Score:
        """Compare a table with the result of `read_truth`. Raises InputError if it cannot be read."""
