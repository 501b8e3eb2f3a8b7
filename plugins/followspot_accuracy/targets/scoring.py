"""Scores per target: coverage, error, uncertainty, identity, false positions, recovery, smoothness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot.messages import Array
from followspot.room import Camera, Room
from followspot.rotation import angle_between
from followspot.tracking import LOST, PREDICTED, TRACKED
from followspot_accuracy.statistics import half_interval, nearest, root_mean_square, share, statistic
from followspot_accuracy.targets.metrics import (
    jerk_cost,
    recoveries,
    reprojection,
    transfers,
    within_ellipsoid,
)
from followspot_accuracy.targets.tables import TrackTable, TruthTable

REACH = 0.15
"""Largest distance at which a position counts as that of the target, m: one ball diameter."""


@dataclass(frozen=True)
class TargetScore:
    """How one target was tracked. A figure is NaN if there was nothing to measure."""

    frames: int
    """Frames in which the target was trackable (25 % visible in two cameras, one of them colour)."""
    coverage: float
    """Share of them with a position within 15 cm of the truth."""
    rmse_mm: float
    """Over all trackable frames with a position, outliers included; so are the next two."""
    median_mm: float
    p95_mm: float
    identity_switches: int
    """How often the position went to another object: within 15 cm of that and not of the target.

    Persons have switches by another rule (`followspot_accuracy.persons.visits.identity_switches`): their
    numbers are given by the tracker, names of targets by the room.
    """
    hidden_frames: int
    """Frames in which the target is hidden from every camera."""
    false_positions: int
    """Hidden frames with a position of state "tracked"."""
    false_share: float
    """Share of the hidden frames."""
    recovery_frames: tuple[int, ...]
    """For each return of the target after it was not trackable: frames from its being visible in a colour
    and an infrared camera to the first right position."""
    recovery_worst: int
    jerk_cost: float
    """Eq. 9-10 of Jin & Qian 2008 in the paper's units: 15 ft, frames, over 100 frame intervals."""
    reprojection_px: float
    """Mean distance of the projections of position and truth over the cameras that have it in view."""
    reprojection_std_px: float
    orientation_deg: float = np.nan
    """Root mean square of the angle to the true orientation, over all trackable frames with one."""
    rated_frames: int = 0
    """Frames with a position that has an uncertainty, and with a truth; also those that are not trackable."""
    within_95: float = np.nan
    """Share of them whose error lies within the ellipsoid of 95 %, by the sigma along each axis."""
    bridged_frames: int = 0
    """Rated frames of state "predicted": without a measurement of its own."""
    bridged_within_95: float = np.nan
    """Share of these, likewise."""
    beyond: float = np.nan
    """Share of the trackable frames with a position that is not within 15 cm: false ones."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Positions of one target at the F times of the truth.

    xyz: (F, 3) m, NaN for none; state: (F,) index of `followspot.tracking.STATES`; quaternion: (F, 4) and
    sigma: (F, 3) m, NaN for none.
    """

    xyz: Array
    state: Array
    quaternion: Array
    sigma: Array

    @property
    def there(self) -> Array:
        """(F,) whether there is a position."""
        return np.isfinite(self.xyz[:, 0])


def score(tracks: TrackTable, truth: TruthTable, room: Room | None = None) -> dict[str, TargetScore]:
    """Compare tracks with the truth, matched by time within half an interval of the truth.

    Scores every object of the truth, then those that only the tracks name, which count as hidden in every
    frame. With a room, also the reprojection error.
    """
    cameras = tuple(room.cameras.values()) if room else ()
    whole = with_absent(truth, [name for name in tracks.objects if name not in truth.objects])
    return {
        name: _target_score(trajectory(tracks, name, whole.time), whole, own, cameras)
        for own, name in enumerate(whole.objects)
    }


def with_absent(truth: TruthTable, names: Sequence[str]) -> TruthTable:
    """The truth with objects added that are never there: hidden in every frame."""

    def added(flags: Array, value: bool) -> Array:
        return np.column_stack([flags, np.full((len(truth.time), len(names)), value)])

    return TruthTable(
        (*truth.objects, *names),
        truth.time,
        np.concatenate([truth.xyz, np.full((len(truth.time), len(names), 3), np.nan)], axis=1),
        added(truth.hidden, True),
        added(truth.trackable, False),
        added(truth.pair, False),
        truth.quaternion,
    )


def trajectory(tracks: TrackTable, name: str, time: Array) -> Trajectory:
    """Rows of one target at the nearest of ascending times (F,), s, none farther than half an interval."""
    xyz, sigma = np.full((2, len(time), 3), np.nan)
    state = np.full(len(time), LOST, np.uint8)
    quaternion = np.full((len(time), 4), np.nan)
    if name in tracks.objects and len(time):
        frame, row = _matched(tracks.time, np.flatnonzero(tracks.target == tracks.objects.index(name)), time)
        xyz[frame] = tracks.xyz[row]
        state[frame] = tracks.state[row]
        if tracks.quaternion is not None:
            quaternion[frame] = tracks.quaternion[row]
        if tracks.sigma is not None:
            sigma[frame] = tracks.sigma[row]
    return Trajectory(xyz, state, quaternion, sigma)


def _matched(moments: Array, rows: Array, time: Array) -> tuple[Array, Array]:
    """Frames that have one of these rows within half an interval, and the row nearest to each.

    moments: (N,) s, of all rows; time: (F,) s, ascending. Of rows that are equally near the last counts.
    """
    frame, distance = nearest(time, moments[rows])
    near = np.flatnonzero(distance <= half_interval(time))
    nearest_first = near[np.argsort(-distance[near], kind="stable")][::-1]
    frames, first = np.unique(frame[nearest_first], return_index=True)
    return frames, rows[nearest_first[first]]


def _target_score(track: Trajectory, truth: TruthTable, own: int, cameras: Sequence[Camera]) -> TargetScore:
    trackable, hidden = truth.trackable[:, own], truth.hidden[:, own]
    distance = np.linalg.norm(track.xyz[:, None] - truth.xyz, axis=2)  # (F, M), NaN if unknown
    right = distance[:, own] < REACH
    elsewhere = (np.delete(distance, own, axis=1) < REACH).any(axis=1) & ~right
    measured = trackable & track.there
    errors_mm = 1000 * distance[measured, own]
    pixels = reprojection(track.xyz[measured], truth.xyz[measured, own], cameras)
    recovery = recoveries(trackable, hidden, truth.pair[:, own], right)
    false = (track.state == TRACKED) & hidden
    rated = np.isfinite(track.sigma).all(axis=1) & np.isfinite(distance[:, own])
    bridged = rated & (track.state == PREDICTED)
    within = within_ellipsoid(track.xyz - truth.xyz[:, own], track.sigma)
    return TargetScore(
        frames=int(trackable.sum()),
        coverage=share(right & trackable, trackable),
        rmse_mm=statistic(errors_mm, root_mean_square),
        median_mm=statistic(errors_mm, np.median),
        p95_mm=statistic(errors_mm, lambda e: float(np.percentile(e, 95))),
        identity_switches=transfers(elsewhere, track.there),
        hidden_frames=int(hidden.sum()),
        false_positions=int(false.sum()),
        false_share=share(false, hidden),
        recovery_frames=recovery,
        recovery_worst=max(recovery, default=0),
        jerk_cost=jerk_cost(track.xyz),
        reprojection_px=statistic(pixels, np.mean),
        reprojection_std_px=statistic(pixels, np.std),
        orientation_deg=_orientation_deg(track.quaternion[measured], truth, own, measured),
        rated_frames=int(rated.sum()),
        within_95=share(within & rated, rated),
        bridged_frames=int(bridged.sum()),
        bridged_within_95=share(within & bridged, bridged),
        beyond=share(measured & ~right, trackable),
    )


def _orientation_deg(quaternion: Array, truth: TruthTable, own: int, measured: Array) -> float:
    """RMS angle to the truth, degrees, of orientations (K, 4) in the measured frames (F,)."""
    if truth.quaternion is None or own >= truth.quaternion.shape[1]:
        return np.nan
    angle = np.degrees(angle_between(truth.quaternion[measured, own], quaternion))
    return statistic(angle[np.isfinite(angle)], root_mean_square)
