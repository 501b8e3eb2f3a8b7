"""The validation gate of boxes (Bar-Shalom): which ones agree with where feet were seen, and with the height.

A camera at the height of heads tells heights most surely: the head's top is in the same row at any distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot_persons.background.floor_contact import Contact
from followspot_persons.body.standing import rise, standing
from followspot_persons.likelihood.fitness import Detection
from followspot_persons.slow_instance.identity import STATURE_SIGMA
from followspot_persons.slow_instance.known_person import KnownPerson
from followspot_persons.slow_instance.part_box import SIZE

GATE = 3.0
"""Largest difference between a box and a known person, in sigmas."""


@dataclass(frozen=True, eq=False)
class ValidationGate:
    """Of N boxes in a picture.

    eye: height of the camera, m; distance: (N,) m, where their sizes say that people stand; slope: (N,) rise
    of the ray to the head's top per metre; certainty: (N,) that a box spans an upper body.
    """

    eye: float
    distance: Array
    slope: Array
    certainty: Array

    @classmethod
    def of(cls, camera: Camera, detections: Sequence[Detection]) -> ValidationGate:
        """The gate of these boxes of a camera."""
        boxes = np.array([d.box for d in detections])
        slope = rise(camera, (boxes[:, 0] + boxes[:, 2]) / 2, boxes[:, 1])
        certainty = np.array([d.certainty for d in detections])
        return cls(float(camera.center[2]), standing(camera, boxes)[0], slope, certainty)

    def refused(self, person: KnownPerson, seconds: float) -> Array:
        """Which boxes are not a person's whose feet were seen, some seconds after the last box: (N,) bool.

        Only boxes of parts err more in size, and seem farther; their upper ends are right.
        """
        if person.contact is None:
            return np.zeros(len(self.distance), bool)
        last, (stature, sigma) = person.contact.later(seconds), person.stature.estimate
        nearer = (last.distance - self.distance) / np.hypot(SIZE * self.distance, last.sigma)
        height = self.eye + last.distance * self.slope
        taller = (height - stature) / np.hypot(np.hypot(sigma, STATURE_SIGMA), self.slope * last.sigma)
        return np.asarray((nearer > GATE) | (np.abs(taller) > GATE))

    def sigmas(self, person: KnownPerson, seconds: float) -> Array:
        """Sigmas by which the sizes of boxes disagree with a person whose feet were seen, some seconds after
        the last box: (N,), 0 if they were not seen.

        A Gaussian of these sigmas is as likely as the Gaussian sum of the person's distance, over its peak.
        """
        if person.contact is None:
            return np.zeros(len(self.distance))
        expected = person.distance.apparent(seconds)
        likelihood = np.sum([share * self._likelihood(place) for share, place in expected], axis=0)
        return np.asarray(np.sqrt(-2 * np.log(np.clip(likelihood, 1e-300, 1.0))))

    def _likelihood(self, expected: Contact) -> Array:
        """Likelihood of the sizes of the boxes over its peak: (N,).

        A box of a part seems farther away than an upper body, and its size says nothing else.
        """
        farther = self.distance - expected.distance
        whole = np.exp(-0.5 * (farther / np.hypot(SIZE * self.distance, expected.sigma)) ** 2)
        part = np.where(farther > 0, 1 - self.certainty, 0.0)
        return np.asarray(np.nan_to_num(part + (1 - part) * whole, nan=1.0))
