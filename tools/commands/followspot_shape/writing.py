"""Write the models as files that people read: one line an entry."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

SHAPE_HEAD = """\
# The upper body of pose tracking, lengths in heights of the body; made by "followspot shape fit".
# outline: elliptic cross-sections at a height `up`, semi-axes to the side and to the front, displaced to the
# front; `rise` in degrees is how far the edge's normal points upwards. surface: places forward, left and up
# from the foot of the body's axis; `outward`: direction from the axis; far sides are hidden by it.
"""
COLOR_HEAD = """\
# How colours of the surface features of people relate; made by "followspot shape colors". Coordinates:
# saturation towards red, saturation towards yellow-green, intensity. mean: of all people; chroma, intensity:
# factors of the covariance between features (the product of two rows); own: variance of a feature by itself.
"""


def write(path: Path, head: str, document: dict[str, Any]) -> None:
    """Write a document of numbers and lists of flat entries as YAML, whole or not at all."""
    lines = []
    for key, value in document.items():
        if isinstance(value, list):
            lines += [f"{key}:", *(f"  - {json.dumps(entry)}" for entry in value)]
        else:
            lines.append(f"{key}: {json.dumps(value)}")
    partial = path.with_name(path.name + ".part")
    partial.write_text(head + "\n".join(lines) + "\n", encoding="utf-8")
    partial.replace(path)
