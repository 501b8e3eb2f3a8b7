"""Warning of cameras whose detections are not assigned to the people that other cameras agree on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

MINIMUM_DETECTIONS = 100
"""Fewest detections of a camera for which it is no accident that most are unassigned."""
MINIMUM_SHARE = 0.9
"""Share of unassigned detections from which the warning names a camera."""


def unassigned_warning(counts: Mapping[str, Sequence[int]]) -> str:
    """A warning that names such cameras; empty if there are none.

    counts: number of detections of each camera while there were people, and of the unassigned ones.
    """
    named = [
        f"{name} ({unassigned} of {detections} detections)"
        for name, (detections, unassigned) in counts.items()
        if detections >= MINIMUM_DETECTIONS and unassigned >= MINIMUM_SHARE * detections
    ]
    if not named:
        return ""
    return (
        f"what {', '.join(named)} detected is none of the people of the other cameras: its calibration or"
        " its times may be wrong (`followspot calibrate check`), its files those of another camera, or it"
        " sees other people"
    )
