"""Names of stages: `color`, and `hall/color` for the stage of a sub-graph."""

from __future__ import annotations

import re

from followspot.valid_values.names import is_name

LONGEST_NAME = 200
SENDER = re.compile(r"([^.]+)(?:\.([^.]+))?")
"""STAGE or STAGE.PORT."""


def is_stage_name(text: str) -> bool:
    """True if a text may name a stage: names that / separates."""
    return len(text) <= LONGEST_NAME and all(is_name(part) for part in text.split("/"))


def below(prefix: str, name: str) -> str:
    """The full name of a stage of a sub-graph; the graph itself has the prefix ""."""
    return f"{prefix}/{name}" if prefix else name


def enclosing(name: str) -> list[str]:
    """The sub-graphs that hold a stage and the stage itself: hall, hall/left, hall/left/color."""
    parts = name.split("/")
    return ["/".join(parts[:count]) for count in range(1, len(parts) + 1)]


def subgraphs(stage: str) -> list[str]:
    """The sub-graphs that hold a stage, the outermost first: hall, hall/left for hall/left/color."""
    return enclosing(stage)[:-1]
