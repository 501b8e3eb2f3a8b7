"""Cameras that are a part of a frame out of step: found from how far ahead of the others they see motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from followspot import Camera
from followspot.messages import Array
from followspot_calibrate.adjust import Free
from followspot_calibrate.adjust.problem import view_of
from followspot_calibrate.adjust.projection import linearise, moved
from followspot_calibrate.clocks.moments import velocities
from followspot_calibrate.sightings import Sightings
from followspot_calibrate.wand.hazards.support import CLEARLY, ENOUGH, support
from followspot_calibrate.wand.hazards.tracks import frame_step, resampled
from followspot_calibrate.wand.rounds import RobustAdjustment

FEWEST = 12
"""Fewest sightings of each camera of points with known motion."""
STEPS = 6
"""Rounds of reweighted least squares."""
CUTOFF = 2.0
"""Median errors at which a sighting counts half."""
CORRELATED = 4.0
"""Sightings that say as much as one, for errors of neighbours are alike."""
LEAST, VAGUE, SINGULAR = 1e-6, 1e-9, 1e-10
"""px^2, 1/m^2 and 1: what keeps equations solvable."""
MOST = 2000
"""Rows that suffice, in stretches spread over the recording; neighbours give the velocity."""
NEAR, STRIDE = 6.0, 0.5
"""Steps up to which the lateness of a camera without a place is sought, and between two that are tried."""
WHOLE = 0.15
"""Steps that a number of lost frames may seem to be off."""
STRETCH = 40
"""Rows of a stretch."""


@dataclass(frozen=True, eq=False)
class Late:
    """Lateness of cameras relative to most of them, and one standard deviation: (C,) frames each.

    cameras: as they are if none is late.
    """

    frames: Array
    sigma: Array
    cameras: tuple[Camera, ...]


def lateness(adjusted: RobustAdjustment, pixel: Array, sightings: Sightings, free: Free) -> Late:
    """The remaining lateness in tracks that are already nearly in step, from motion.

    pixel: (N, C, 2) px of the frames and labels of the sightings; free: other parameters left free, because
    a pose or a lens adjusted to a late camera hides most of its lateness. A camera sees a point that
    moves with v at its place after its lateness l: P(X + v l). Points are eliminated (H&Z, appendix A6.3.1).
    """
    velocity = _velocities(sightings, adjusted.points)
    known = np.isfinite(velocity[:, 0] + adjusted.points[:, 0])
    points, speed, count = adjusted.points[known], velocity[known], len(adjusted.cameras)
    linear = [
        _linear(camera, points, speed, pixel[known, number], free)
        for number, camera in enumerate(adjusted.cameras)
    ]
    if min(len(one.rows) for one in linear) < FEWEST:
        return Late(np.zeros(count), np.full(count, np.inf), adjusted.cameras)
    change = [np.zeros(free.parameters + 1)] * count
    shift = np.zeros_like(points)
    for _ in range(STEPS):
        weights = [one.weights(step, shift) for one, step in zip(linear, change, strict=True)]
        try:
            change, shift, spread = _solved(linear, weights, len(points), free.parameters + 1)
        except np.linalg.LinAlgError:  # points that their cameras do not determine
            return Late(np.zeros(count), np.full(count, np.inf), adjusted.cameras)
    frames = np.array([step[-1] for step in change])
    cameras = (_stepped(c, step[:-1], free) for c, step in zip(adjusted.cameras, change, strict=True))
    return Late(frames - np.median(frames), spread, tuple(cameras))


@dataclass(frozen=True, eq=False)
class _Linear:
    """The linearised sightings of one camera.

    rows: (M,); error: (M, 2) px; by_camera: (M, 2, P), derivatives by its parameters, the lateness
    last; by_point: (M, 2, 3).
    """

    rows: Array
    error: Array
    by_camera: Array
    by_point: Array

    def weights(self, step: Array, shift: Array) -> Array:
        """Cauchy weights of what is left of the errors, relative to their median: (M,)."""
        left = self.error - self.by_camera @ step - (self.by_point @ shift[self.rows][..., None])[..., 0]
        square = np.square(left).sum(axis=1)
        return np.asarray(1 / (1 + square / max(float(np.median(square)) * CUTOFF**2, LEAST)))


def _linear(camera: Camera, points: Array, velocity: Array, pixel: Array, free: Free) -> _Linear:
    flat, view = view_of(camera, pixel, free)
    seen, by_camera, by_point = linearise(flat, points[view.rows], free)
    motion = by_point @ velocity[view.rows][..., None]
    return _Linear(view.rows, view.pixel - seen, np.concatenate([by_camera, motion], axis=2), by_point)


def _stepped(camera: Camera, step: Array, free: Free) -> Camera:
    """The camera after a change of what is open; another model than pinhole keeps its lens."""
    if camera.model == "pinhole":
        return moved(camera, step, free)
    return moved(camera, step[: Free().parameters], Free())


def _solved(
    linear: Sequence[_Linear], weights: Sequence[Array], points: int, size: int
) -> tuple[list[Array], Array, Array]:
    """The change of each camera, (P,), of each point, (N, 3), and the sigma of each lateness, (C,) frames."""
    count = len(linear)
    own, toward = np.tile(VAGUE * np.eye(3), (points, 1, 1)), np.zeros((points, 3))
    mixed = np.zeros((points, 3, count * size))
    normal, aim = np.zeros((count * size, count * size)), np.zeros(count * size)
    for number, (one, weight) in enumerate(zip(linear, weights, strict=True)):
        at = slice(number * size, (number + 1) * size)
        weighted = one.by_camera * weight[:, None, None]
        normal[at, at] = np.einsum("nip,niq->pq", weighted, one.by_camera)
        aim[at] = np.einsum("nip,ni->p", weighted, one.error)
        mixed[one.rows, :, at] = one.by_point.swapaxes(1, 2) @ weighted
        own[one.rows] += one.by_point.swapaxes(1, 2) @ (one.by_point * weight[:, None, None])
        toward[one.rows] += np.einsum("nik,ni->nk", one.by_point * weight[:, None, None], one.error)
    inverse = np.linalg.inv(own)
    tied = (inverse @ mixed).reshape(-1, count * size)
    normal -= mixed.reshape(-1, count * size).T @ tied
    aim -= tied.T @ toward.ravel()
    scale = np.sqrt(np.maximum(np.diagonal(normal), VAGUE))
    solved = np.linalg.pinv(normal / np.outer(scale, scale), rcond=SINGULAR, hermitian=True)
    solved /= np.outer(scale, scale)
    step = solved @ aim
    shift = (inverse @ (toward - (mixed @ step))[..., None])[..., 0]
    noise = np.median(np.concatenate([np.square(one.error).sum(axis=1) for one in linear]))
    sigma = np.sqrt(CORRELATED * noise * np.maximum(np.diagonal(solved)[size - 1 :: size], 0.0))
    return np.split(step, count), shift, sigma


def _velocities(sightings: Sightings, points: Array) -> Array:
    """Velocities of points per frame: (N, 3); NaN without neighbours."""
    order = np.lexsort([sightings.frame, sightings.label])
    found = np.empty_like(points)
    found[order] = velocities(sightings.frame[order].astype(float), sightings.label[order], points[order])
    return found


def nearest_shift(lens: Camera, points: Array, sightings: Sightings, number: int) -> float:
    """Lateness of a camera without a pose among points, up to `NEAR` steps, in frames; 0 if there is none.

    points: (N, 3), NaN if unknown; number: of the camera.
    """
    late = np.zeros(len(sightings.cameras))
    best, most = 0.0, max(ENOUGH, CLEARLY * support(lens, points, sightings.pixel[:, number]).share)
    for shift in frame_step(sightings) * np.arange(-NEAR, NEAR + STRIDE, STRIDE):
        late[number] = shift
        share = support(lens, points, resampled(sightings, late)[:, number]).share
        if share > most:
            best, most = float(shift), share
    return best


def drift(
    adjusted: RobustAdjustment, sightings: Sightings, late: Array, free: Free, sure: float, least: float
) -> Array:
    """Growth of the lateness from the first half to the second, (C,) frames; 0 if it is not significant.

    late: (C,) frames, in all; sure: smallest growth in sigmas, least: in frames. A camera that is not late
    can only have lost whole frames: one that was moved seems to lose parts of frames.
    """
    pixel, second = resampled(sightings, late), sightings.frame > np.median(sightings.frame)
    before, after = (
        lateness(replace(adjusted, points=adjusted.points[rows]), pixel[rows], sightings.rows(rows), free)
        for rows in (~second, second)
    )
    growth, sigma = after.frames - before.frames, np.hypot(before.sigma, after.sigma)
    steps = growth / frame_step(sightings)
    whole = np.abs(steps - np.round(steps)) < WHOLE
    believed = ((late != 0) | whole) & (np.abs(growth) > np.maximum(least, sure * sigma))
    return np.asarray(np.where(believed, growth, 0.0))


def stretches(sightings: Sightings) -> Array:
    """Some of the rows, in whole stretches of time: numbers, by label and frame."""
    order = np.lexsort([sightings.frame, sightings.label])
    parts = max(1, len(order) // STRETCH)
    chosen = np.linspace(0, parts - 1, min(parts, MOST // STRETCH)).astype(int)
    return np.concatenate([np.array_split(order, parts)[part] for part in chosen])
