"""The result of a refinement as a table and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from followspot.tables import table
from followspot_calibrate.adjust.prior import rotation_vector
from followspot_calibrate.refine.solving import Refinement

HEAD = ("camera", "moved mm", "turned deg", "focal %", "sightings", "px before", "px after")


def rows(found: Refinement) -> Iterator[tuple[str, float, float, float, int, float, float]]:
    """The change of each camera, and its median error before and after."""
    before, after = (np.nanmedian(one.distance, axis=0) for one in (found.before, found.after))
    count = found.after.used.sum(axis=0)
    for i, (old, new) in enumerate(zip(found.before.cameras, found.after.cameras, strict=True)):
        yield (
            old.name,
            float(1000 * np.linalg.norm(new.center - old.center)),
            float(np.degrees(np.linalg.norm(rotation_vector(new.rotation @ old.rotation.T)))),
            float(100 * (new.matrix[0, 0] / old.matrix[0, 0] - 1)),
            int(count[i]),
            float(before[i]),
            float(after[i]),
        )


def cells(found: Refinement) -> list[tuple[str, ...]]:
    """The same as text."""
    return [
        (name, f"{mm:.1f}", f"{turn:.3f}", f"{focal:+.2f}", str(n), f"{old:.2f}", f"{new:.2f}")
        for name, mm, turn, focal, n, old, new in rows(found)
    ]


def verdict(found: Refinement) -> str:
    """The reprojection error as it was and as it is."""
    old, new = (float(np.nanmedian(one.distance)) for one in (found.before, found.after))
    return f"reprojection error {old:.2f} px before, {new:.2f} px after (median of {len(found.pixel)} places)"


def as_text(found: Refinement) -> str:
    """The table and the verdict."""
    return f"{table(HEAD, cells(found))}\n{verdict(found)}"


def as_json(found: Refinement) -> dict[str, Any]:
    """The same for scripts."""
    keys = ("moved_mm", "turned_degrees", "focal_percent", "sightings", "before_px", "after_px")
    cameras = {name: dict(zip(keys, values, strict=True)) for name, *values in rows(found)}
    planes = {name: plane.tolist() for name, plane in found.planes.items()}
    return {"cameras": cameras, "planes": planes, "places": len(found.pixel)}
