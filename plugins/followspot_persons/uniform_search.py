"""Search for people without a detector: particles that begin everywhere (Weinrich et al. 2010, section 4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from followspot import Array, Camera, Field, InputPath, Stage, StageParams
from followspot.frame_times import NANOSECOND
from followspot.geometry import ray
from followspot.people import Boxes, Gradients
from followspot.tracking import Frame
from followspot_persons.body.shape import SHIPPED as SHIPPED_SHAPE
from followspot_persons.body.shape import read_shape
from followspot_persons.body.stature import SPREAD, USUAL
from followspot_persons.body.view import HEADING, HEIGHT, view
from followspot_persons.box_geometry import ARMS
from followspot_persons.gradients import FindGradients
from followspot_persons.likelihood.fitness import Fitness, PosePrior, Weights, pictured
from followspot_persons.panorama import short_way, turn_of
from followspot_persons.particles.ascent import ascend
from followspot_persons.particles.condensation import systematic
from followspot_persons.particles.motion import limited, predicted
from followspot_persons.particles.spawning import NEAREST

APART = 0.7
"""Smallest distance between two people, m."""
MOST = 8
"""Most people in a picture."""
EVIDENCE = 0.05
"""Likelihood above the smallest one that raises the score by 1."""
POWER = 40.0
"""Power of eq. 7 in a particle's weight."""
LEAST = -500.0
"""Logarithm of the smallest weight, of poses without an image too, so that no sum of weights is 0."""
CLIMBING, ROUNDS = 0.1, 2
"""Share of the particles with gradient ascent, and its rounds."""


class UniformSearch(Stage):
    """Find people by their outlines alone: particles everywhere, and a share of them anew in every picture.

    Furniture has outlines, too, so the stage suits only rooms with plain walls. It also serves to measure how
    much a detector contributes.
    """

    per_camera = True

    class Params(StageParams):
        shape: InputPath = Field(SHIPPED_SHAPE, description="shape model of head and upper body")
        particles: int = Field(
            2000,
            ge=100,
            le=50_000,
            unit="1",
            description="particles of the picture; raising it finds people sooner and costs time",
        )
        random_share: float = Field(
            0.5,
            ge=0,
            le=0.9,
            unit="1",
            description="share of particles that are placed anew; raising it finds new people sooner",
        )
        largest_distance: float = Field(
            6.0, gt=NEAREST, le=50, unit="m", description="largest distance of people from the camera"
        )
        minimum_likelihood: float = Field(
            0.75,
            gt=0,
            lt=1,
            unit="1",
            description="smallest likelihood of a person; raising it finds fewer people and fewer false ones",
        )

    params: Params

    def setup(self) -> None:
        """Place particles everywhere."""
        p = self.params
        self.shape = read_shape(p.shape)
        self.edges = FindGradients(self.context)
        self.edges.setup()
        self.particles = self.anywhere(p.particles)
        self.time = -1
        self.warned = False

    def anywhere(self, count: int) -> Array:
        """Poses uniform in direction, distance and heading, (count, 6)."""
        return uniform_poses(self.camera, count, self.params.largest_distance, self.rng)

    def process(self, frame: Frame) -> Boxes:
        now = frame.header.time
        seconds = max(now - self.time, 0) * NANOSECOND if self.time >= 0 else 0.0
        self.time = now
        if frame.pixels.shape[1::-1] != tuple(self.camera.size):
            if not self.warned:
                self.log.warning(
                    "%s: pictures are not of the camera's size and are not searched", frame.camera
                )
            self.warned = True
            return self.boxes(frame.camera, self.particles[:0], np.empty(0))
        gradients: Gradients = self.edges.process(frame)
        picture = pictured(self.camera, frame, gradients)
        fitness = Fitness(picture, self.shape, Weights(sharpness=POWER), PosePrior(USUAL, SPREAD))
        kept = len(self.particles) - int(self.params.random_share * len(self.particles))
        moved = predicted(self.particles[:kept], np.zeros(2), seconds, self.camera.center, self.rng)
        cloud = np.concatenate([moved, self.anywhere(len(self.particles) - kept)])
        weight = shared(cloud, fitness(cloud))
        cloud = self.rng.permutation(cloud[systematic(weight, len(cloud), self.rng)])
        climbing = cloud[: int(CLIMBING * len(cloud))]
        climbing[:], _ = ascend(climbing, fitness(climbing), fitness, self.camera.center, ROUNDS)
        self.particles = cloud
        return self.boxes(frame.camera, climbing, fitness.likelihood(climbing))

    def state(self) -> Any:
        return {"particles": self.particles, "time": self.time}

    def restore(self, state: Any) -> None:
        self.particles, self.time = np.array(state["particles"], float), int(state["time"])

    def boxes(self, camera: str, particles: Array, likelihood: Array) -> Boxes:
        """Boxes of the maxima, one in a direction: the others are the same outline at other distances."""
        found = maxima(particles, likelihood, self.params.minimum_likelihood)
        box = view(self.camera, self.shape, particles[found]).box.reshape(-1, 4)
        kept = separate(box, turn_of(self.camera))
        best, unknown = np.array(found, int)[kept], np.empty((len(kept), 0))
        return Boxes(
            camera=camera,
            box=box[kept],
            score=(likelihood[best] - self.params.minimum_likelihood) / EVIDENCE,
            torso=unknown,
            head=unknown,
        )


def uniform_poses(camera: Camera, count: int, farthest: float, rng: np.random.Generator) -> Array:
    """Poses that the picture shows: uniform in its columns, in distance up to `farthest` (m), in heading."""
    width, height = camera.size
    pixel = np.column_stack([rng.uniform(0, width, count), np.full(count, height / 2)])
    toward = ray(camera, pixel)[:, :2]
    toward = toward / np.maximum(np.hypot(toward[:, :1], toward[:, 1:]), 1e-9)
    pose = np.zeros((count, 6))
    pose[:, :2] = camera.center[:2] + rng.uniform(NEAREST, farthest, (count, 1)) * toward
    pose[:, HEIGHT] = USUAL + SPREAD * rng.standard_normal(count)
    pose[:, HEADING] = rng.uniform(-np.pi, np.pi, count)
    return limited(pose)


def shared(pose: Array, value: Array) -> Array:
    """Weights of particles, of which every maximum gets the same sum: one person must not take all.

    pose: (N, 6); value: (N,) logarithms of the weights. Returns (N,), sum 1.
    """
    value = np.where(np.isfinite(value), value, LEAST)
    weight = np.exp(np.maximum(value - value.max(), LEAST))
    best = maxima(pose, value)
    near = np.hypot(*(pose[:, None, :2] - pose[best][None, :, :2]).transpose(2, 0, 1)).argmin(axis=1)
    weight /= np.bincount(near, weight, len(best))[near]
    return np.asarray(weight / weight.sum())


def maxima(pose: Array, value: Array, least: float = -np.inf) -> list[int]:
    """Rows of the best poses of at least this value, the best first, none within `APART` of a better one.

    pose: (N, 6); value: (N,).
    """
    found: list[int] = []
    left = np.where(value >= least, value, -np.inf)
    while len(found) < MOST and np.isfinite(left.max(initial=-np.inf)):
        best = int(left.argmax())
        found.append(best)
        left[np.hypot(*(pose[:, :2] - pose[best, :2]).T) < APART] = -np.inf
    return found


def separate(box: Array, turn: int) -> list[int]:
    """Rows of boxes whose middle is beside all better ones.

    box: (N, 4) px, the best first; turn: columns of a full turn, 0 for none.
    """
    kept: list[int] = []
    middle, height = (box[:, 0] + box[:, 2]) / 2, box[:, 3] - box[:, 1]
    for row in range(len(box)):
        apart = short_way(middle[row] - middle[kept], turn)
        if (np.abs(apart) > ARMS * np.maximum(height[kept], height[row])).all():
            kept.append(row)
    return kept
