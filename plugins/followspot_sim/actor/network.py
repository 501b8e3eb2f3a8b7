"""Simulated results of a network for poses and boxes of actors: noisy, with gaps and mistakes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera, Field
from followspot.geometry import project
from followspot_sim.actor.parameters import ActorParams

GIRTH = 0.2
"""Radius of the column that a body hides behind it, m."""
OUTLIER, OUTLIER_SIGMA = 0.02, 0.15
"""Share of joints that are elsewhere, and how far, m."""
GUESSED, GUESS_FACTOR = 0.2, 3.0
"""Share of hidden joints that the network tells all the same, and the factor of their errors."""
LEAST = 5
"""Visible joints of a person that is found."""
ABOVE, BELOW, ASIDE = 0.13, 0.08, 0.10
"""By how much a body reaches beyond its landmarks: head, feet, sides, m."""


class NetworkParams(ActorParams):
    """The performance, and the mistakes of a network."""

    pixel_sigma: float = Field(1.5, ge=0, le=100, unit="px", description="sigma of a joint in the picture")
    body_sigma: float = Field(
        0.02, ge=0, le=1, unit="m", description="sigma of a joint on the body, in addition"
    )
    joint_miss: float = Field(0.05, ge=0, le=1, unit="1", description="share of visible joints not found")
    person_miss: float = Field(0.04, ge=0, le=1, unit="1", description="share of visible persons not found")
    clutter: float = Field(
        0.3, ge=0, le=20, unit="1", description="mean number of false persons in a picture"
    )
    exchange_share: float = Field(
        0.0,
        ge=0,
        le=0.5,
        unit="1",
        description="share of the pictures of a person whose left and right are exchanged, in arms, legs or "
        "everywhere; 1.9 times as large from behind, 0.1 times from the front",
    )
    exchange_time: float = Field(0.6, gt=0, le=60, unit="s", description="duration of one such exchange")
    late_by: float = Field(
        0.0,
        ge=0,
        le=1,
        unit="s",
        description="delay of this camera's pictures after their time stamps",
    )


@dataclass(frozen=True, eq=False)
class Finding:
    """Persons in a picture in random order. pixel: (N, 17, 2) px, NaN for joints that were not found; score:
    (N, 17); box: (N, 4) px.
    """

    pixel: Array
    score: Array
    box: Array


def found_in(
    camera: Camera,
    joints: Array,
    heights: Array,
    names: Array,
    given: NetworkParams,
    rng: np.random.Generator,
) -> Finding:
    """joints: (P, 17, 3) m; heights: (P,) m of the people's heads; names: (P, 17), of each joint the one by
    whose name it goes.
    """
    there, seen = _pixels(camera, joints), visible(camera, joints, heights)
    seen &= ((there >= 0) & (there <= np.array(camera.size) - 1)).all(axis=-1)
    pixel, score = _noisy(camera, joints, there, seen, given, rng)
    pixel, score = np.take_along_axis(pixel, names[..., None], 1), np.take_along_axis(score, names, 1)
    box = _boxes(camera, joints, seen, rng)
    caught = (seen.sum(axis=1) >= LEAST) & (rng.random(len(joints)) >= given.person_miss)
    false = _false(camera, there, given, rng)
    pixel, score = np.concatenate([pixel[caught], false.pixel]), np.concatenate([score[caught], false.score])
    box = np.concatenate([box[caught], false.box])
    order = rng.permutation(len(box))
    return Finding(pixel[order], score[order], box[order])


def visible(camera: Camera, joints: Array, heights: Array) -> Array:
    """Whether no other person stands between the camera and each joint, (P, 17)."""
    eye = camera.center
    middle = joints[:, :, :2].mean(axis=1)
    ray = joints[:, :, None, :2] - eye[:2]
    across = middle - eye[:2]
    share = (ray * across).sum(axis=-1) / np.maximum((ray**2).sum(axis=-1), 1e-9)
    share = np.clip(share, 0.0, 1.0)
    near = np.linalg.norm(share[..., None] * ray - across, axis=-1) < GIRTH
    level = eye[2] + share * (joints[:, :, None, 2] - eye[2])
    hidden = near & (share < 0.97) & (level < heights)
    hidden[np.arange(len(joints)), :, np.arange(len(joints))] = False
    return np.asarray(~hidden.any(axis=2))


def _pixels(camera: Camera, points: Array) -> Array:
    return project(camera, points.reshape(-1, 3)).reshape(*points.shape[:-1], 2)


def _noisy(
    camera: Camera,
    joints: Array,
    there: Array,
    seen: Array,
    given: NetworkParams,
    rng: np.random.Generator,
) -> tuple[Array, Array]:
    """Places (P, 17, 2) px and scores (P, 17) of found joints."""
    depth = np.linalg.norm(joints - camera.center, axis=-1)
    metre = camera.matrix[0, 0] / np.maximum(depth, 0.1)
    sigma = np.hypot(given.pixel_sigma, given.body_sigma * metre)
    sigma = np.where(rng.random(seen.shape) < OUTLIER, OUTLIER_SIGMA * metre, sigma)
    sigma = np.where(seen, sigma, GUESS_FACTOR * sigma)
    told = np.where(seen, rng.random(seen.shape) >= given.joint_miss, rng.random(seen.shape) < GUESSED)
    pixel = there + sigma[..., None] * rng.standard_normal(there.shape)
    score = np.where(seen, rng.uniform(0.5, 1.0, seen.shape), rng.uniform(0.1, 0.5, seen.shape))
    return np.where(told[..., None], pixel, np.nan), score


def _boxes(camera: Camera, joints: Array, seen: Array, rng: np.random.Generator) -> Array:
    """Boxes about what is seen of each person, (P, 4) px, cut by the picture's border."""
    right = np.cross(camera.rotation[2], [0.0, 0.0, 1.0])
    right *= ASIDE / max(float(np.linalg.norm(right)), 1e-6)
    reach = np.array([right, -right, [0.0, 0.0, ABOVE], [0.0, 0.0, -BELOW]])
    ends = _pixels(camera, joints[:, :, None] + reach)
    ends[~seen] = np.nan
    flat = ends.reshape(len(joints), joints.shape[1] * len(reach), 2)
    known = np.isfinite(flat)
    low = np.where(known, flat, np.inf).min(axis=1, initial=np.inf)
    high = np.where(known, flat, -np.inf).max(axis=1, initial=-np.inf)
    edges = np.hstack([low, high])
    height = np.maximum(edges[:, 3] - edges[:, 1], 1.0)
    edges = edges + 0.03 * height[:, None] * rng.standard_normal(edges.shape)
    size = np.tile(np.array(camera.size, float) - 1, 2)
    return np.asarray(np.clip(edges, 0.0, size))


def _false(camera: Camera, there: Array, given: NetworkParams, rng: np.random.Generator) -> Finding:
    """False persons: people of the picture moved elsewhere, of whom half the joints are missing."""
    whole = np.flatnonzero(np.isfinite(there).all(axis=(1, 2))) if len(there) else np.zeros(0, int)
    count = int(rng.poisson(given.clutter)) if len(whole) else 0
    pixel = there[rng.choice(whole, count)] if count else np.zeros((0, 17, 2))
    middle = rng.uniform(0, 1, (count, 1, 2)) * np.array(camera.size)
    pixel = (pixel - pixel.mean(axis=1, keepdims=True)) * rng.uniform(0.5, 1.2, (count, 1, 1)) + middle
    box = np.concatenate([pixel.min(axis=1), pixel.max(axis=1)], axis=1)
    pixel[rng.random(pixel.shape[:2]) < 0.5] = np.nan
    return Finding(pixel, rng.uniform(0.1, 0.7, pixel.shape[:2]), box)
