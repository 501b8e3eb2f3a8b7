"""The message types of multi-view tracking, shared by all plugins so that stages can be swapped.

`T` is the number of targets of the room, in the order of the room file. A column of shape (N, T) says for
each of N rows which targets it may belong to. Messages name cameras; numbers of cameras index the message's
`cameras`.
"""

from __future__ import annotations

from typing import Self

import numpy as np

from followspot.messages import Array, Message, column
from followspot.room import Room
from followspot.tables.table_column import TableColumn
from followspot.valid_values.target_numbers import target_numbers

LOST, TRACKED, MISSING, PREDICTED = 0, 1, 2, 3
STATES = ("lost", "tracked", "missing", "predicted")
"""Life cycle of a target (Jin & Qian 2008, section 3.8). Column `state` holds the index.

lost: searched for in whole images. tracked: measured in this frame. missing: not measured, searched
for near its last place first. predicted: no measurement of its own, bridged by the motion model or a
plane; its position is an extrapolation.
"""


class Frame(Message):
    """One picture of one camera, in the room's size: BGR for colour cameras, grey for infrared ones."""

    camera: str
    pixels: Array = column("H", "W", "C", dtype="u1")


class DepthImage(Message):
    """One depth image of one depth camera, in the room's size.

    The depth of a pixel is that of the surface along the optical axis (z of the camera's coordinates), not
    its distance from the camera: `followspot.geometry.depth_rays` leads to the point in the room.
    """

    camera: str
    depth: Array = column("H", "W", dtype="f4", unit="m")
    """0 where the camera measured nothing."""


class Blobs(Message):
    """Blobs that a detector found in one picture."""

    camera: str
    xy: Array = column("N", 2, unit="px")
    """Centroid with the lens distortion removed (same matrix K)."""
    pixel: Array = column("N", 2, unit="px")
    """The same centroid in the distorted picture."""
    area: Array = column("N", unit="px")
    """Number of pixels."""
    similarity: Array = column("N")
    """Bhattacharyya coefficient with the template (eq. 2); 1 for infrared blobs."""
    targets: Array = column("N", "T", dtype="?")
    """Targets that the blob may belong to: by colour and search region, or by search region alone."""

    def as_table(self, room: Room) -> list[TableColumn]:
        """A row for each blob and target that it may belong to; one without a target if it has none."""
        blob, target = np.argwhere(np.column_stack([self.targets, ~self.targets.any(axis=1)])).T
        known = [*room.targets, *map(str, range(len(room.targets), self.targets.shape[1]))]
        u, v = self.pixel[blob].T
        x, y = self.xy[blob].T
        return [
            TableColumn("camera", [self.camera] * len(blob)),
            TableColumn("target", np.array([*known[: self.targets.shape[1]], ""], object)[target]),
            TableColumn("u", u, "px", 3),
            TableColumn("v", v, "px", 3),
            TableColumn("area", self.area[blob], "px", 0),
            TableColumn("similarity", self.similarity[blob], decimals=4),
            TableColumn("blob", blob, extra=True),
            TableColumn("x", x, "px", 3, extra=True),
            TableColumn("y", y, "px", 3, extra=True),
        ]


class Pairs(Message):
    """Blobs of two cameras that may show the same thing."""

    cameras: tuple[str, ...]
    view: Array = column("N", 2, dtype="i4", refers="cameras")
    """The two cameras, as indices of `cameras`."""
    blob: Array = column("N", 2, dtype="i4")
    """Row of the blob in each camera's `Blobs`."""
    xy: Array = column("N", 2, 2, unit="px")
    """Undistorted centroid in each view."""
    area: Array = column("N", 2, unit="px")
    """Number of pixels of the blob in each view."""
    epipolar: Array = column("N", unit="px")
    """Epipolar distance d_ED."""
    labelled: Array = column("N", dtype="?")
    """True if one of the cameras is a colour camera; infrared-infrared pairs are unlabelled."""
    confirmed: Array = column("N", dtype="?")
    """True if the pair is evidence of a ball: it joins a colour and an infrared camera, which tells a ball
    from a lamp; if all cameras that send are of one kind, every pair is that is not surely light."""
    evident: Array = column("N", dtype="?")
    """True if the pair alone may start a track: confirmed, and no other colour camera contradicts it."""
    targets: Array = column("N", "T", dtype="?")
    clutter: Array = column("N", 2)
    """Density of clutter around each blob over the usual one: below 1 if its view has shown few blobs there
    while a target was lost that the blob may be."""


class Candidates(Message):
    """3D candidates, one per pair (section 3.5), with the pair that made each."""

    cameras: tuple[str, ...]
    xyz: Array = column("N", 3, unit="m")
    view: Array = column("N", 2, dtype="i4", refers="cameras")
    blob: Array = column("N", 2, dtype="i4")
    xy: Array = column("N", 2, 2, unit="px")
    area: Array = column("N", 2, unit="px")
    """Number of pixels of the blob in each view."""
    epipolar: Array = column("N", unit="px")
    labelled: Array = column("N", dtype="?")
    confirmed: Array = column("N", dtype="?")
    evident: Array = column("N", dtype="?")
    """True if the pair is evident and both blobs are large enough for a ball at that distance."""
    targets: Array = column("N", "T", dtype="?")
    clutter: Array = column("N", 2)
    """As of `Pairs`."""


class ExistenceOdds(Message):
    """How sure an association is that each tracked target exists; one row per target of the room."""

    odds: Array = column("T", unit="nats")
    """Log-odds that the target exists at its tracked position; NaN if it is not tracked, or not weighed."""
    given_up: Array = column("T", dtype="?")
    """True if the track ends in this frame, for the odds are too low: nothing may prolong it."""


class Positions(Message):
    """Fused measurements, at most one row per target; targets that were not seen have no row."""

    target: Array = column("M", dtype="i4", refers="targets")
    xyz: Array = column("M", 3, unit="m")
    covariance: Array = column("M", 3, 3, unit="m^2")
    """Covariance of the measurement; NaN if the fusion does not estimate it."""
    support: Array = column("M", dtype="i4")
    """Number of candidates that the fusion used. A fusion that weighs all views counts fewer if these doubt
    the place of a lost target, and more if they make it sure."""
    confirmed: Array = column("M", dtype="?")
    """True if a confirmed pair is among them; only such a position recovers a lost target."""
    evident: Array = column("M", dtype="?")
    """True if one of them (without support: one nearby) alone may start a track after a few frames."""
    iterations: Array = column("M", dtype="i4")
    """Steps until convergence; 0 for direct methods."""
    predicted: Array = column("M", dtype="?")
    """True if the position comes from one view and the forecast or a plane: it is no measurement."""

    @classmethod
    def fused(
        cls,
        candidates: Candidates,
        target: Array,
        used: Array,
        xyz: Array,
        covariance: Array | None = None,
        iterations: Array | int = 0,
    ) -> Self:
        """The positions that a fusion gives some targets, with what the candidates that it used tell of them.

        target: (M,) numbers of the targets; used: (M, N) bool, the candidates of each; xyz: (M, 3) m;
        covariance: (M, 3, 3) m^2, None if the fusion estimates none; iterations: (M,), or one number for all.
        Raises ValueError if a number is that of no target, or there twice.
        """
        return cls(
            target=target_numbers(target, candidates.targets.shape[1]),
            xyz=xyz,
            covariance=np.full((len(target), 3, 3), np.nan) if covariance is None else covariance,
            support=used.sum(axis=1, dtype=np.int32),
            confirmed=np.asarray((used & candidates.confirmed).any(axis=1)),
            evident=np.asarray((used & candidates.evident).any(axis=1)),
            iterations=np.full(len(target), iterations, np.int32),
            predicted=np.zeros(len(target), bool),
        )


class Forecast(Message):
    """Predicted position of each target at the next frame; one row per target of the room."""

    period: float
    """Time from this message to the frame it forecasts, s."""
    state: Array = column("T", dtype="u1", refers="states")
    """State that decides the search region; at times a missing target is searched for like a lost one."""
    xyz: Array = column("T", 3, unit="m")
    velocity: Array = column("T", 3, unit="m/s")
    covariance: Array = column("T", 3, 3, unit="m^2")
    last: Array = column("T", 3, unit="m")
    """Final estimate at the last frame in which the target was tracked."""
    before: Array = column("T", 3, unit="m")
    """Final estimate one frame earlier; the expected travel is last - before (eq. 3)."""


class Tracks(Message):
    """Filtered targets whose position is known, one row each; the output of a tracker."""

    target: Array = column("M", dtype="i4", refers="targets")
    state: Array = column("M", dtype="u1", refers="states")
    xyz: Array = column("M", 3, unit="m", decimals=6)
    velocity: Array = column("M", 3, unit="m/s", names="vx vy vz", decimals=6)
    sigma: Array = column("M", 3, unit="m", names="sx sy sz", decimals=6)
    """One standard deviation along each axis."""


class Truth(Message):
    """Ground truth of one frame."""

    objects: tuple[str, ...]
    """Name of each object, one a row."""
    xyz: Array = column("M", 3, unit="m")
    hidden: Array = column("M", dtype="?")
    """Less than 5 % visible in every camera."""
    trackable: Array = column("M", dtype="?")
    """At least 25 % visible in two cameras, one of them colour if the room has any, or in a depth camera."""
    pair: Array = column("M", dtype="?")
    """At least 50 % visible in two cameras, a colour and an infrared one if the room has both kinds, or in a
    depth camera."""

    def as_table(self, room: Room) -> list[TableColumn]:
        """The columns of a file of ground truth (`cameras.truth_csv`)."""
        flags = (
            TableColumn(name, getattr(self, name).astype("u1")) for name in ("hidden", "trackable", "pair")
        )
        place = (TableColumn(axis, values, "m") for axis, values in zip("xyz", self.xyz.T, strict=True))
        names = [*self.objects, *[""] * len(self.xyz)][: len(self.xyz)]
        return [TableColumn("object", names), *place, *flags]


class ImageTracks(Message):
    """Image tracks of one camera that were measured in this frame, one row each."""

    camera: str
    target: Array = column("M", dtype="i4", refers="targets", names="target")
    track: Array = column("M", dtype="i4")
    """Number of the track; each throw of a target has its own."""
    xy: Array = column("M", 2, unit="px", decimals=3, extra=True)
    """Position with the lens distortion removed (same matrix K)."""
    pixel: Array = column("M", 2, unit="px", names="u v", decimals=3)
    """The same position in the distorted picture."""
    velocity: Array = column("M", 2, unit="px/s", names="du dv", decimals=3)
    residual: Array = column("M", unit="px", decimals=3)
    """RMS distance of the track so far from the motion model."""
