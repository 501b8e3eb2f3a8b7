"""MoveNet MultiPose (Google 2021): up to six people in a whole picture, 17 joints of COCO each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot import Array
from followspot_persons.pose_net.contract import Decoder, People

PAIRS = ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
COCO = (
    "nose",
    *(f"{side}_{part}" for part in ("eye", "ear") for side in ("left", "right")),
    *(f"{side}_{part}" for part in PAIRS for side in ("left", "right")),
)

MOST = 1000
"""Most people in an output."""


class MoveNetMultiPose(Decoder):
    """Input (1, H, W, 3) int32 RGB, sides multiples of 32; output (1, 6, 56).

    A row has y, x, score of 17 joints, then a box, which is not used, and the score of the person; places are
    shares of the image's sides.
    """

    joints = COCO
    minimum_score = 0.25

    def tensor(self, image: Array) -> Array:
        return image[None].astype(np.int32)

    def people(self, outputs: Sequence[Array], size: tuple[int, int]) -> People:
        found = outputs[0]
        columns = 3 * len(COCO) + 5
        shape = found.shape
        if len(shape) != 3 or shape[0] != 1 or shape[1] > MOST or shape[2] != columns:
            raise ValueError(f"an output of MoveNet MultiPose is (1, people, {columns}), not {shape}")
        joints = found[0, :, : 3 * len(COCO)].reshape(-1, len(COCO), 3).astype(float)
        pixel = joints[..., 1::-1] * np.array(size) - 0.5
        return People(pixel, joints[..., 2], found[0, :, -1].astype(float))
