"""Cameras whose detections are none of the people that other cameras agree on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

MANY = 100
"""Fewest detections of a camera for which it is no accident that most are unassigned."""
SHARE = 0.9
"""Share of unassigned detections from which the warning names a camera."""


def doubt_of_strangers(strangers: Mapping[str, Sequence[int]]) -> str:
    """A warning that names such cameras; empty if there are none.

    strangers: number of detections of each camera while there were people, and of the unassigned ones.
    """
    doubted = [
        f"{name} ({nobodys} of {detections} detections)"
        for name, (detections, nobodys) in strangers.items()
        if detections >= MANY and nobodys >= SHARE * detections
    ]
    if not doubted:
        return ""
    return (
        f"what {', '.join(doubted)} detected is none of the people of the other cameras: its calibration or"
        " its times may be wrong (`followspot calibrate check`), its files those of another camera, or it"
        " sees other people"
    )
