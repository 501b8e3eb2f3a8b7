"""The message types of points that any detector finds, in pictures and in space, each with a label."""

from __future__ import annotations

from followspot.messages import Array, Message, column


class Points2D(Message):
    """Points in one picture: the place of a marker, the centre of a box, a joint of a body."""

    camera: str
    labels: tuple[str, ...]
    """The texts that `label` indexes, in any order; the name of a target of the room means that target."""
    label: Array = column("N", dtype="i4", refers="labels")
    instance: Array = column("N", dtype="i4")
    """Number within the picture of the thing that the point is a part of, from 0; -1 if it is not said."""
    pixel: Array = column("N", 2, unit="px", names="u v", decimals=3)
    """In the picture as it was taken."""
    xy: Array = column("N", 2, unit="px", decimals=3, extra=True)
    """With the lens distortion removed (same matrix K)."""
    score: Array = column("N")
    """Certainty, larger is more certain; 1 if it is not said."""


class Points3D(Message):
    """Points in the room."""

    labels: tuple[str, ...]
    """As in `Points2D`."""
    label: Array = column("N", dtype="i4", refers="labels")
    xyz: Array = column("N", 3, unit="m", decimals=6)
    covariance: Array = column("N", 3, 3, unit="m^2", extra=True)
    """NaN if it is not known."""
    views: Array = column("N", dtype="i4")
    """Number of cameras that saw the point; 0 if it comes from elsewhere."""
    error: Array = column("N", unit="px", decimals=3)
    """RMS distance of its images from the points that it was made of; NaN if it comes from elsewhere."""
    score: Array = column("N")
    """Mean of their scores."""
