"""The body that fitting starts from: proportions of adults, in body heights."""

from __future__ import annotations

from typing import Any

import numpy as np

NECK, BOTTOM = 0.845, 0.603
"""Height of the joint of the neck, and height at which the boxes of the crops end, in body heights."""
SECTIONS = [
    ("crown", "head", 1.0, 0.0, 0.0, 0.03, 90.0),
    ("brow", "head", 0.965, 0.040, 0.052, 0.03, 20.0),
    ("ears", "head", 0.93, 0.045, 0.055, 0.03, 0.0),
    ("jaw", "head", 0.895, 0.036, 0.045, 0.035, -20.0),
    ("neck", "torso", 0.862, 0.033, 0.035, 0.01, 0.0),
    ("collar", "torso", 0.832, 0.062, 0.040, 0.0, 60.0),
    ("shoulder", "torso", 0.80, 0.115, 0.050, 0.0, 35.0),
    ("chest", "torso", 0.75, 0.135, 0.075, 0.0, 5.0),
    ("arm", "torso", 0.70, 0.140, 0.080, 0.0, 0.0),
    ("waist", "torso", 0.63, 0.140, 0.080, 0.0, 0.0),
]
"""Name, part, height, semi-axes to the side and to the front, displacement to the front; degrees by which the
edge's normal rises above the horizontal."""
RINGS = [("hair", "head", 0.968, 8), ("face", "head", 0.922, 8)] + [
    (name, "torso", up, 8) for name, up in (("chest", 0.775), ("ribs", 0.71), ("belly", 0.645))
]
"""Name, part, height and number of the features around the body."""
SINGLE = [
    ("mouth", "head", 0.897, 1.0, 0.0),
    ("throat", "torso", 0.85, 1.0, 0.0),
    ("nape", "torso", 0.85, -1.0, 0.0),
    ("left shoulder", "torso", 0.815, 0.0, 1.0),
    ("right shoulder", "torso", 0.815, 0.0, -1.0),
]
"""Name, part, height, and the direction from the axis, forward and left, that they face."""
INSET = 0.72
"""Distance of surface features from the axis over that of the outline; less than 1 tolerates near misses."""


def surface(sections: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """The surface features of a body with this outline: entries of the file."""
    features = []
    for name, part, up, count in RINGS:
        for k in range(count):
            angle = 2 * np.pi * k / count
            degrees = round(np.degrees(angle))
            features.append(
                _feature(f"{name} {degrees}", part, up, np.array([np.cos(angle), np.sin(angle)]), sections)
            )
    return [
        _feature(name, part, up, np.array([forward, left]), sections)
        for name, part, up, forward, left in SINGLE
    ] + features


def _feature(name: str, part: str, up: float, outward: Any, sections: list[dict[str, Any]]) -> dict[str, Any]:
    by_height = sorted((s for s in sections if s["part"] == part), key=lambda s: s["up"])
    depth, width, forward = (
        np.interp(up, [s["up"] for s in by_height], [s[key] for s in by_height])
        for key in ("depth", "width", "forward")
    )
    place = INSET * outward * [depth, width]
    return {
        "name": name,
        "part": part,
        "position": [round(float(x), 4) for x in (forward + place[0], place[1], up)],
        "outward": [round(float(x), 4) for x in outward],
    }
