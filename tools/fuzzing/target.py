"""One way into the program that fuzzing tries, and what came of it."""

from __future__ import annotations

import random
import re
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

_VARIABLE = re.compile(r"'[^']*'|\"[^\"]*\"|[\[{(].*|[^\s]*[\d/][^\s]*")
_MOST_REASONS = 200
MORE_MB = 2048
"""Address space that a process may take beyond what it has at the start."""


@dataclass(frozen=True)
class Target:
    """make: a broken input; take: gives it to the program, which returns or raises one of `rejections`.

    longest_s: work for one input, s; one that only waits has twelve times as long; most_mb: memory of the
    whole process, 0: `MORE_MB` beyond what it has at the start.
    """

    make: Callable[[random.Random], Any]
    take: Callable[[Any], object]
    rejections: tuple[type[Exception], ...]
    longest_s: float = 10.0
    most_mb: int = 0


@dataclass
class Outcome:
    """The results. refused: by reason; crashes: failures that must never happen."""

    inputs: int = 0
    accepted: int = 0
    refused: Counter[str] = field(default_factory=Counter)
    crashes: list[str] = field(default_factory=list)
    slowest_s: float = 0.0
    peak_mb: float = 0.0
    whole_mb: float = 0.0

    def to_data(self) -> dict[str, Any]:
        """JSON types."""
        return {**vars(self), "refused": dict(self.refused)}

    def refuse(self, error: object) -> None:
        """Count a refusal."""
        reason = reason_of(error)
        self.refused[reason if reason in self.refused or len(self.refused) < _MOST_REASONS else "other"] += 1


def reason_of(error: object) -> str:
    """The text of a refusal without what differs from input to input: names, numbers and paths."""
    return " ".join(_VARIABLE.sub(" ", str(error).split("\n")[0]).split()[:8]) or type(error).__name__
