"""The validation gate of boxes (Bar-Shalom): which ones agree with where feet were seen, and with the height.

A camera at the height of heads tells heights most surely: the head's top is in the same row at any distance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array, Camera
from followspot_persons.body.standing import rise, standing
from followspot_persons.slow_instance.identity import STATURE_SIGMA
from followspot_persons.slow_instance.known_person import KnownPerson
from followspot_persons.slow_instance.part_box import SIZE

GATE = 3.0
"""Largest difference between a box and a known person, in sigmas."""


@dataclass(frozen=True, eq=False)
class ValidationGate:
    """Of N boxes in a picture.

    eye: height of the camera, m; distance: (N,) m, where their sizes say that people stand; slope: (N,) rise
    of the ray to the head's top per metre.
    """

    eye: float
    distance: Array
    slope: Array

    @classmethod
    def of(cls, camera: Camera, boxes: Array) -> ValidationGate:
        """The gate of these boxes (N, 4) px of a camera."""
        slope = rise(camera, (boxes[:, 0] + boxes[:, 2]) / 2, boxes[:, 1])
        return cls(float(camera.center[2]), standing(camera, boxes)[0], slope)

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
