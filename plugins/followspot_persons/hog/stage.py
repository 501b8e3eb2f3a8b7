"""Upper bodies by histograms of oriented gradients (Weinrich et al. 2010, section 3.2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from followspot import Array, Field, InputPath, Stage, StageParams
from followspot.people import Boxes
from followspot.tracking import Frame
from followspot_persons.hog.model import (
    DIRECTIONS,
    SHIPPED,
    SHIPPED_ABOVE,
    Classification,
    HogModel,
    classify,
    joined,
    load,
)
from followspot_persons.hog.search import Level, groups, levels, outermost, plausible, proposals
from followspot_persons.hog.whole import parts, raised
from followspot_persons.hog.whole_model import SHIPPED_WHOLE
from followspot_persons.hog.whole_model import load as load_whole
from followspot_persons.hog.window import HEIGHT, WIDTH, cut, detector
from followspot_persons.panorama import turn_of

SAME = 0.45
"""Smallest overlap of two boxes of the same body."""
NESTED = 0.75
"""Smallest share of the smaller box in the larger one for the same body."""
CROWD = 4.0
"""Usual number of windows that show a body; false bodies show in fewer."""
FAINT = -2.5
"""Smallest log-odds of these windows."""


@dataclass(frozen=True, eq=False)
class Search:
    """Windows of some sizes and rows, and the weights that know them."""

    model: HogModel
    levels: Sequence[Level]

    @cached_property
    def detector(self) -> cv2.HOGDescriptor:
        """Proposes windows."""
        return detector(self.model.linear)


class Hog(Stage):
    """Find upper bodies of any orientation where people may stand, with the headings of torso and head.

    A linear detector proposes windows; a small network classifies them, together with boosted trees if the
    weights have them. If a window is in doubt, legs below the upper body can raise its score. The stage is
    slow: run it every few frames.
    """

    per_camera = True

    class Params(StageParams):
        frame_interval: int = Field(
            1, ge=1, unit="frames", description="one frame in so many is searched; raising it saves time"
        )
        minimum_height: float = Field(
            32.0,
            ge=16,
            unit="px",
            description="smallest upper body; lowering it finds distant people and costs time",
        )
        maximum_height: float = Field(
            320.0,
            ge=16,
            unit="px",
            description="largest upper body; raising it finds close people and costs time",
        )
        scale_step: float = Field(
            1.1,
            ge=1.02,
            le=2,
            unit="1",
            description="ratio of successive search sizes; raising it saves time",
        )
        minimum_person_height: float = Field(
            1.2,
            gt=0,
            unit="m",
            description="shortest person; lowering it finds children, and more false people",
        )
        maximum_person_height: float = Field(
            2.1, gt=0, unit="m", description="tallest person; raising it finds more false people"
        )
        minimum_score: float = Field(
            0.0,
            unit="1",
            description="smallest score (log-odds); raising it finds fewer people, and fewer false ones",
        )
        maximum_proposals: int = Field(
            400,
            ge=1,
            le=5000,
            unit="1",
            description="windows that are classified, best first; raising it costs time",
        )
        weights: InputPath = Field(SHIPPED, description="weights, as `followspot train hog` makes them")
        weights_above: InputPath = Field(
            SHIPPED_ABOVE,
            description="weights for windows that reach above the picture, as `followspot train hog --above` "
            "makes them",
        )
        weights_whole: InputPath = Field(
            SHIPPED_WHOLE,
            description="weights that classify whole bodies, as `followspot train whole` makes them",
        )
        whole_share: float = Field(
            0.5,
            ge=0,
            le=1,
            unit="1",
            description="share of the whole body in a score that it raises; raising it finds more people "
            "whose legs are seen, and more false ones; 0 looks at upper bodies alone",
        )

    params: Params

    def setup(self) -> None:
        """Read the weights and plan the search. Raises InputError if the weights are invalid."""
        p = self.params
        self.heights = (p.minimum_person_height, p.maximum_person_height)
        sizes = (p.minimum_height, max(p.minimum_height, p.maximum_height))
        self.searches = [
            Search(load(path), levels(self.camera, sizes, p.scale_step, self.heights, above=above))
            for path, above in ((p.weights, False), (p.weights_above, True))
        ]
        self.whole = load_whole(p.weights_whole)
        self.turn = float(turn_of(self.camera))

    def process(self, frame: Frame) -> Boxes | None:
        if max(frame.header.seq, 0) % self.params.frame_interval:
            return None
        pixels = frame.pixels
        if pixels.shape[2] == 1:
            pixels = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_GRAY2BGR))
        proposed = [self.proposed(pixels, search) for search in self.searches]
        box, share = np.concatenate(proposed), self.params.whole_share
        pixels, placed = self.around(pixels, box)
        of_search = np.split(placed, np.cumsum([len(part) for part in proposed])[:-1])
        found = joined(
            [
                classified_boxes(pixels, part, s.model)
                for s, part in zip(self.searches, of_search, strict=True)
            ]
        )
        score = raised(self.whole, share, pixels, placed, found.score) if share else found.score
        return self.boxes(box, found, score)

    def proposed(self, pixels: Array, search: Search) -> Array:
        """Proposed boxes, (N, 4) px."""
        box, score = proposals(pixels, self.camera, search.levels, search.detector)
        best = np.argsort(-score, kind="stable")
        best = best[plausible(self.camera, box[best], self.heights)]
        return np.asarray(box[best[: self.params.maximum_proposals]])

    def around(self, pixels: Array, box: Array) -> tuple[Array, Array]:
        """The picture, continued beyond the border of a panorama, and the boxes (N, 4) px in it."""
        if not self.turn or not len(box):
            return pixels, box
        beyond = max(0.0, box[:, 2].max() - self.turn) + (box[:, 3] - box[:, 1]).max()
        margin = int(np.ceil(beyond))
        wider = cv2.copyMakeBorder(pixels, 0, 0, margin, margin, cv2.BORDER_WRAP)
        return np.asarray(wider), box + np.array([margin, 0, margin, 0])

    def boxes(self, box: Array, classification: Classification, score: Array) -> Boxes:
        """One box for each body: the mean of the windows that show it, weighted by their odds.

        Its odds are the sum over the windows, whole bodies included, over the usual number of windows. Legs
        say that somebody is there; where the upper body is and how it faces, it says alone.
        score: (N,) log-odds of somebody, with the whole bodies.
        """
        shown = score > FAINT
        box, odds, upper = box[shown], np.exp(score[shown]), np.exp(classification.score[shown])
        torso, head = classification.torso[shown], classification.head[shown]
        found = groups(box, odds, SAME, self.turn)
        means, angles = np.empty((len(found), 4)), np.empty((2, len(found), DIRECTIONS))
        for number, rows in enumerate(found):
            weight = upper[rows] / upper[rows].sum()
            means[number] = weight @ self.beside(box[rows])
            angles[:, number] = weight @ torso[rows], weight @ head[rows]
        total, own = (np.array([each[rows].sum() for rows in found]) for each in (odds, upper))
        best = outermost(means, total, NESTED, self.turn)
        least = CROWD * np.exp(self.params.minimum_score)
        best = best[total[best] > least]
        best = best[~parts(means[best], own[best] <= least, NESTED, self.turn)]
        return Boxes(
            camera=self.camera.name,
            box=means[best],
            score=np.log(total[best] / CROWD),
            torso=angles[0, best],
            head=angles[1, best],
        )

    def beside(self, box: Array) -> Array:
        """Boxes (N, 4), moved by full turns next to the first."""
        if not self.turn:
            return box
        turns = np.rint((box[:, :1] - box[0, 0]) / self.turn)
        return np.asarray(box - turns * self.turn * [1, 0, 1, 0])


def classified_boxes(pixels: Array, box: Array, model: HogModel) -> Classification:
    """What the model says of the contents of boxes (N, 4) px."""
    return classify(
        model, np.array([cut(pixels, one) for one in box], np.uint8).reshape(-1, HEIGHT, WIDTH, 3)
    )
