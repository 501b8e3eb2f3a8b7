"""Cameras whose detections are none of the people that other cameras agree on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

MANY = 100
"""Detections of a camera from which on it is no accident that they are nobody's."""
SHARE = 0.9
"""Of its detections that are nobody's, from which on a camera is doubted."""


def doubt_of_strangers(strangers: Mapping[str, Sequence[int]]) -> str:
    """A warning that names such cameras; empty if there are none.

    strangers: detections of each camera while there were people, and how many of them were nobody's.
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
