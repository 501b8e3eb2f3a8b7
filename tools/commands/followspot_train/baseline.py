"""OpenCV's detector of whole people on the same persons and backgrounds, for comparison."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from followspot import Array
from followspot_persons.people_detector import STRIDE, UPPER, WINDOW, people_hog
from followspot_train.figures import by_folder, score_at
from followspot_train.linear import sizes
from followspot_train.pictures import Pictures

LEAST = -3.0
"""Score below which a window of a background is not kept."""


def recall(pictures: Pictures, rate: float) -> dict[str, Any]:
    """Recall of OpenCV's detector on all persons, at a rate of false positives on all backgrounds.

    The last row of a crop that ends at the waist is repeated.
    """
    hog = people_hog()
    scores, searched = [np.zeros(0)], 0
    for background in pictures.backgrounds:
        for picture in sizes(background.pixels, WINDOW):
            down, across = (picture.shape[0] - WINDOW[1], picture.shape[1] - WINDOW[0])
            searched += (across // STRIDE[0] + 1) * (down // STRIDE[1] + 1)
            scores.append(np.ravel(hog.detect(picture, LEAST, STRIDE, (0, 0))[1]))
    least = score_at(np.concatenate(scores), searched, rate)
    weights = np.ravel(cv2.HOGDescriptor.getDefaultPeopleDetector())
    hit = np.array([_score(hog, weights, p.pixels, p.box) > least for p in pictures.persons], bool)
    return by_folder(hit, [person.folder for person in pictures.persons])


def _score(hog: cv2.HOGDescriptor, weights: Array, pixels: Array, box: Array) -> float:
    """Score of the window that has the upper body at the place of the detector's."""
    scale = (box[3] - box[1]) / (UPPER[3] - UPPER[1])
    left = (box[0] + box[2]) / 2 - scale * WINDOW[0] / 2
    place = np.array([[scale, 0, left], [0, scale, box[1] - scale * UPPER[1]]])
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    window = cv2.warpAffine(pixels, place, WINDOW, flags=flags, borderMode=cv2.BORDER_REPLICATE)
    return float(np.ravel(hog.compute(window)) @ weights[:-1] + weights[-1])
