"""The messages of markers: their corners in pictures, and their poses in the room."""

from __future__ import annotations

from followspot.messages import Array, Message, column

CORNERS = "u0 v0 u1 v1 u2 v2 u3 v3"


class Markers(Message):
    """Square markers that a detector found in one picture, one row each; no name stands twice."""

    camera: str
    names: tuple[str, ...]
    """The texts that `marker` indexes."""
    marker: Array = column("N", dtype="i4", refers="names")
    id: Array = column("N", dtype="i4")
    """Number in the dictionary."""
    pixel: Array = column("N", 4, 2, unit="px", names=CORNERS, decimals=3)
    """Corners in the picture, clockwise as one looks at the marker, from its upper left one."""
    xy: Array = column("N", 4, 2, unit="px", decimals=3, extra=True)
    """The same corners with the lens distortion removed (same matrix K)."""


class MarkerPoses(Message):
    """Markers in the room, one row each.

    The axes of a marker begin in its middle: x to its right, y to its top, z out of its face.
    """

    names: tuple[str, ...]
    """The texts that `marker` indexes."""
    marker: Array = column("N", dtype="i4", refers="names")
    xyz: Array = column("N", 3, unit="m", decimals=6)
    """The middle of the marker."""
    rotation: Array = column("N", 4, names="qw qx qy qz", decimals=6)
    """Unit quaternion of the rotation from the marker's axes to those of the room; qw is not negative."""
    views: Array = column("N", dtype="i4")
    """Number of cameras that saw it."""
    error: Array = column("N", unit="px", decimals=3)
    """RMS distance of the corners from their images."""
    ambiguity: Array = column("N", decimals=3)
    """Error over that of the other pose that a flat square may have, 0 to 1: near 1 both explain the
    pictures. 0 if there is no other."""
