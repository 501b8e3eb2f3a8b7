"""Names of the joints of bodies, in the order in which other programs list them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from followspot.errors import InputError

_HEAD = ("nose", "left_eye", "right_eye", "left_ear", "right_ear")
_PAIRS = ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
COCO = (*_HEAD, *(f"{side}_{joint}" for joint in _PAIRS for side in ("left", "right")))
"""17 joints: COCO keypoints, and the programs trained on them."""
_ARMS = (
    "nose",
    "neck",
    *(f"{side}_{joint}" for side in ("right", "left") for joint in ("shoulder", "elbow", "wrist")),
)
_LEGS = tuple(f"{side}_{joint}" for side in ("right", "left") for joint in ("hip", "knee", "ankle"))
_FACE = ("right_eye", "left_eye", "right_ear", "left_ear")
_FEET = tuple(f"{side}_{part}" for side in ("left", "right") for part in ("big_toe", "small_toe", "heel"))
OPENPOSE_18 = (*_ARMS, *_LEGS, *_FACE)
BODY_25 = (*_ARMS, "mid_hip", *_LEGS, *_FACE, *_FEET)

SKELETONS: Mapping[int, Sequence[str]] = {17: COCO, 18: OPENPOSE_18, 25: BODY_25}
"""By their number of joints."""


def joint_names(count: int, given: Sequence[str], file: str) -> Sequence[str]:
    """Names of so many joints; given: the user's, if any. Raises InputError if they do not fit."""
    names = given or SKELETONS.get(count, ())
    if len(names) != count:
        known = ", ".join(f"{number} ({joints[0]}, {joints[1]}, ...)" for number, joints in SKELETONS.items())
        text = f"{file} has persons with {count} joints" + (f", joints names {len(given)}" if given else "")
        raise InputError.of(text, f"name them in their order: joints: [...]; known are those of {known}")
    return names
