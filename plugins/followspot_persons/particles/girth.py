"""The girth of a person's torso over the body height, learnt while the person is tracked.

People of one height differ by a fifth, and a model of the wrong width fits best at the wrong distance. The
paper had principal components of breast, stomach and shoulders and left them out for speed; one number a
person does most of it, and changes so slowly that it needs no place in the particles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_persons.body.shape import ShapeModel, with_girth
from followspot_persons.body.view import view
from followspot_persons.likelihood.fitness import Fitness
from followspot_persons.particles.ascent import DISTANCE, moved

GIRTHS = np.linspace(0.78, 1.14, 10)
"""Compared girths, in girths of the shape model."""
USUAL, SPREAD = 0.96, 0.08
"""Mean and sigma of people's girths."""
WEIGHT = 4.0
"""Power of the edge likelihood in one picture's evidence."""
NEIGHBOURHOOD = (-0.12, -0.08, -0.04, 0.0, 0.04, 0.08, 0.12)
"""Compared distances, relative to the pose's."""
MEMORY = 0.97
"""Share of the evidence that the next picture keeps."""


@dataclass(frozen=True, eq=False)
class Girth:
    """Log-evidence of each of `GIRTHS`, (10,)."""

    evidence: Array

    @classmethod
    def unknown(cls) -> Girth:
        """The girth of a person before any picture."""
        return cls(np.zeros(len(GIRTHS)))

    @property
    def mean(self) -> float:
        """The expected girth."""
        log = self.evidence - 0.5 * ((GIRTHS - USUAL) / SPREAD) ** 2
        weight = np.exp(log - log.max())
        return float(weight @ GIRTHS / weight.sum())


def girths_of(shape: ShapeModel) -> ShapeModel:
    """The model for as many bodies as :func:`observed` compares: each of `GIRTHS` at each distance."""
    return with_girth(shape, np.repeat(GIRTHS, len(NEIGHBOURHOOD)))


def observed(girth: Girth, fitness: Fitness, bodies: ShapeModel, pose: Array) -> Girth:
    """After one more picture, in which a person has a pose (6,): each body where it fits best.

    bodies: of :func:`girths_of`.
    """
    camera = fitness.picture.camera
    distance = float(np.hypot(*(pose[:2] - camera.center[:2])))
    near = np.concatenate(
        [moved(pose[None], camera.center, DISTANCE, share * distance) for share in NEIGHBOURHOOD]
    )
    edge = fitness.edge(view(camera, bodies, np.tile(near, (len(GIRTHS), 1))))
    log = np.log(np.maximum(edge.reshape(len(GIRTHS), -1).max(axis=1), 1e-3))
    return Girth(MEMORY * girth.evidence + WEIGHT * (log - log.max()))
