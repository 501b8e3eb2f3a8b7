"""BlazePose landmarks (Bazarevsky et al. 2020): 33 joints of the person that an image is cut out about."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Array
from followspot_persons.pose_net.contract import Decoder, People
from followspot_persons.pose_net.movenet import PAIRS

ROWS, COLUMNS = 39, 5
"""Landmarks in the output, of which the last six place the next image; x, y, z, visibility and presence."""
EYE = ("eye_inner", "eye", "eye_outer")


class BlazePose(Decoder):
    """Input (1, 256, 256, 3) float32 RGB from 0 to 1; outputs of 195 and of 1 numbers among others.

    The 195 are 39 landmarks: x, y, z in px of the image and two log-odds. The 1 is the probability that the
    image shows a person. The image is upright; heat maps, depths and the silhouette are not used.
    """

    joints = (
        "nose",
        *(f"{side}_{part}" for side in ("left", "right") for part in EYE),
        "left_ear",
        "right_ear",
        "mouth_left",
        "mouth_right",
        *(f"{side}_{part}" for part in PAIRS[:3] for side in ("left", "right")),
        *(f"{side}_{part}" for part in ("pinky", "index", "thumb") for side in ("left", "right")),
        *(f"{side}_{part}" for part in PAIRS[3:] for side in ("left", "right")),
        *(f"{side}_{part}" for part in ("heel", "foot_index") for side in ("left", "right")),
    )
    per_box = True
    size = (256, 256)
    minimum_score = 0.5

    def tensor(self, image: Array) -> Array:
        return np.asarray(image[None] / np.float32(255), np.float32)

    def people(self, outputs: Sequence[Array], size: tuple[int, int]) -> People:
        landmarks = [output for output in outputs if output.size == ROWS * COLUMNS]
        flags = [output for output in outputs if output.size == 1]
        if len(landmarks) != 1 or len(flags) != 1:
            sizes = [output.size for output in outputs]
            raise ValueError(f"BlazePose has outputs of {ROWS * COLUMNS} and of 1 numbers, not {sizes}")
        found = landmarks[0].reshape(1, ROWS, COLUMNS)[:, : len(self.joints)].astype(float)
        certainty = 1 / (1 + np.exp(-np.clip(found[..., 3], -50, 50)))
        return People(found[..., :2] - 0.5, certainty, flags[0].reshape(1).astype(float))
