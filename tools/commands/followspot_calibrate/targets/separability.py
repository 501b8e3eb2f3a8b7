"""Separability of the targets' colours: the share of a target's blobs that another's template accepts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from followspot import Target
from followspot.messages import Array
from followspot_balls.detection.hue import bhattacharyya, normalised
from followspot_balls.detection.rival_colors import TOLD_APART
from followspot_balls.templates.from_clip import ColorSpots

SIMILARITY, HUE_SHARE, SMALLEST, LARGEST = 0.8, 0.02, 0.3, 1.5
"""The default of `balls.color_blobs`."""
ALIKE = 0.8
"""Similarity of two templates from which there is a warning."""
CONFUSED = 0.1
"""Share of a target's blobs accepted as another target from which there is a warning."""
_REMEDY = (
    "each blob goes to the target that it fits best, which fails if light changes the hues; for more safety "
    "choose another colour for one"
)
_NOT_TOLD_APART = "nothing tells them apart: choose another colour for one, 30 degrees of hue away or more"


@dataclass(frozen=True, eq=False)
class Separability:
    """Separability of T targets in one camera.

    similarity: (T, T), Bhattacharyya coefficient of the templates; accepted: (T, T), share of the blobs of
    the row's target that the template of the column's target accepts.
    """

    camera: str
    targets: tuple[str, ...]
    similarity: Array
    accepted: Array

    @property
    def warnings(self) -> list[str]:
        """Which two targets are confused, each with the remedy."""
        found = []
        for i, a in enumerate(self.targets):
            for j, b in enumerate(self.targets[:i]):
                share = max(self.accepted[i, j], self.accepted[j, i])
                if self.similarity[i, j] >= ALIKE or share >= CONFUSED:
                    one, other = (a, b) if self.accepted[i, j] >= self.accepted[j, i] else (b, a)
                    found.append(
                        f"{b} and {a} look alike in {self.camera}: similarity {self.similarity[i, j]:.2f}; "
                        f"{100 * share:.0f} % of the blobs of {one} would pass for {other}; "
                        + (_REMEDY if self.similarity[i, j] < TOLD_APART else _NOT_TOLD_APART)
                    )
        return found


def separability(
    camera: str, targets: Mapping[str, Target], spots: Mapping[str, ColorSpots]
) -> Separability | None:
    """Separability of the targets in one colour camera; None for fewer than two.

    spots: of the targets with clips; for others a blob is made from the template.
    """
    names = tuple(name for name, target in targets.items() if camera in target.hue_histogram)
    if len(names) < 2:
        return None
    template = np.array([targets[name].hue_histogram[camera] for name in names])
    areas = [targets[name].area.get(camera, (0.0, np.inf)) for name in names]
    accepted = np.array(
        [
            [accepted_share(blobs, histogram, area) for histogram, area in zip(template, areas, strict=True)]
            for blobs in (spots.get(name) or stand_in(targets[name], camera) for name in names)
        ]
    )
    return Separability(camera, names, bhattacharyya(template[:, None], template), accepted)


def accepted_share(spots: ColorSpots, histogram: Array, area: tuple[float, float]) -> float:
    """Share of a target's blobs that the detector would accept as the target with this template.

    The detector sees only pixels of the template's hues: these must be enough, and mixed as in the template.
    """
    member = histogram >= HUE_SHARE
    kept = np.where(member, spots.counts, 0)
    share = kept.sum(axis=1) / np.maximum(spots.counts.sum(axis=1), 1e-12)
    size = spots.area * share
    fits = (size >= SMALLEST * area[0]) & (size <= LARGEST * area[1]) & (share > 0)
    return float((fits & (bhattacharyya(normalised(kept), histogram) > SIMILARITY)).mean())


def worst(found: Sequence[Separability]) -> Separability:
    """The worst of all cameras, each pair by itself."""
    names = tuple(dict.fromkeys(name for one in found for name in one.targets))
    similarity, accepted = np.zeros((2, len(names), len(names)))
    for one in found:
        place = np.ix_(*[[names.index(name) for name in one.targets]] * 2)
        similarity[place] = np.maximum(similarity[place], one.similarity)
        accepted[place] = np.maximum(accepted[place], one.accepted)
    return Separability("any camera", names, similarity, accepted)


def stand_in(target: Target, camera: str) -> ColorSpots:
    """One blob that looks like the template, of a usual size."""
    area = float(np.mean(target.area.get(camera, (1.0, 1.0))))
    return ColorSpots(target.hue_histogram[camera][None], np.array([area]))
