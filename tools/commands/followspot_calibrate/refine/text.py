"""The result of a refinement as a table and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np

from followspot.tables.terminal import table
from followspot_calibrate.adjust.prior import rotation_vector
from followspot_calibrate.refine.cross_validation import Comparison
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
    """The cells of a row as text."""
    return [
        (name, f"{mm:.1f}", f"{turn:.3f}", f"{focal:+.2f}", str(n), f"{old:.2f}", f"{new:.2f}")
        for name, mm, turn, focal, n, old, new in rows(found)
    ]


def verdict(found: Refinement) -> str:
    """The reprojection error as it was and as it is."""
    old, new = (float(np.nanmedian(one.distance)) for one in (found.before, found.after))
    return f"reprojection error {old:.2f} px before, {new:.2f} px after (median of {len(found.pixel)} places)"


def left_out(held: Comparison) -> str:
    """The errors of sightings that took no part."""
    return f"places that took no part: {held.given:.2f} px before, {held.best:.2f} px after"


def warnings_of(held: Comparison | None) -> list[str]:
    """The text on the choice between given and refined cameras, with and without clips."""
    if held is None:
        return [
            "the recording has too few places to check the refined cameras with others: "
            "record the targets at more places, or look at the new cameras before you use them"
        ]
    warnings = []
    if held.clips is not None and not held.use_clips:
        warnings.append(
            "the clips were left out: places of the recording that took no part are seen with "
            f"{held.clips:.2f} px of error with them, {held.alone:.2f} px without. Are they synchronised; "
            "did no camera move between clips and recording?"
        )
    if not held.better:
        warnings.append(
            "the cameras stay as they are: they see places that took no part with "
            f"{held.given:.2f} px of error, refined with {held.best:.2f} px"
        )
    return warnings


def as_text(found: Refinement) -> str:
    """The table and the verdict."""
    return f"{table(HEAD, cells(found))}\n{verdict(found)}"


def as_json(found: Refinement) -> dict[str, Any]:
    """The result as JSON, for scripts."""
    keys = ("moved_mm", "turned_degrees", "focal_percent", "sightings", "before_px", "after_px")
    cameras = {name: dict(zip(keys, values, strict=True)) for name, *values in rows(found)}
    planes = {name: plane.tolist() for name, plane in found.planes.items()}
    return {"cameras": cameras, "planes": planes, "places": len(found.pixel)}


def comparison_as_json(held: Comparison | None) -> dict[str, Any] | None:
    """The errors of places that took no part, px, and what follows from them."""
    return None if held is None else asdict(held) | {"use_clips": held.use_clips, "better": held.better}
