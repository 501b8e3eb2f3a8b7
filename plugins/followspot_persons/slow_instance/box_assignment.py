"""Which box of the detector is whose: near in the picture, and of the person's colours."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot import Array, Camera
from followspot.frame_times import NANOSECOND
from followspot.people import Boxes
from followspot_persons.body.shape import ShapeModel
from followspot_persons.body.view import BodyView, view
from followspot_persons.box_geometry import box_offsets, carried, on_body
from followspot_persons.color.difference import ColorRelations, at_large, completed
from followspot_persons.color.likelihood import color_likelihood, feature_responses
from followspot_persons.color.model import ColorModel
from followspot_persons.likelihood.certainty import certainties
from followspot_persons.likelihood.fitness import Detection, Picture, sampled
from followspot_persons.nearest_neighbours import matched
from followspot_persons.panorama import turn_of
from followspot_persons.slow_instance.known_person import KnownPerson
from followspot_persons.slow_instance.validation_gate import GATE, ValidationGate

NEAR, FAR = 0.5, 1.5
"""Distance between the boxes of a person at which they may belong together, in heights: at once, and more for
each second since the last one, for a body is 0.7 m high to the waist and people walk a metre a second."""
WALK = 1.0
"""Growth of a person's distance with the time since the last box, m/s. A person nearby cannot be
far away at once; a person who seemed far away, by boxes of the head alone, can be near.
"""
COLOR_SHARE = 0.3
"""Weight of minus log F^C against the distance, relative to this limit, when boxes are given to persons."""
MAXIMUM_MISMATCH = 2.0
"""Minus log F^C of a person with other clothes."""


@dataclass(frozen=True, eq=False)
class BoxAssignment:
    """Of one camera, with the shape model and the relations of colours.

    specific: whether a box is only a known person's whose colours are likelier than those of people at large.
    """

    camera: Camera
    shape: ShapeModel
    relations: ColorRelations
    specific: bool = False

    @property
    def turn(self) -> int:
        """Columns of a full turn, 0 for none."""
        return turn_of(self.camera)

    def pairs(
        self,
        people: list[KnownPerson],
        detections: list[Detection],
        still: Array,
        upright: Array,
        picture: Picture,
        now: int,
    ) -> list[tuple[int, int]]:
        """Pairs of person and box: near in the picture, and of the person's colours.

        Tentative persons, whose colours nobody knows, get what known ones leave. still: (N,) bool, boxes that
        show the background, which are given only to people who are a part of it. upright: (N,) bool,
        boxes of the foreground, which are a known person's only if its colours beat those of people at large.
        """
        if not people or not detections:
            return []
        boxes = np.array([d.box for d in detections])
        gate = ValidationGate.of(self.camera, detections)
        limit = 1 + COLOR_SHARE * MAXIMUM_MISMATCH
        cost = np.empty((len(people), len(boxes)))
        for i, person in enumerate(people):
            age = (now - person.seen) * NANOSECOND
            seen = view(self.camera, self.shape, person.track.pose[None])
            cost[i] = self._distance(person, seen, boxes, gate, age)
            cost[i, still & person.comparable] = np.inf
            for j in np.flatnonzero(cost[i] < limit):
                cost[i, j] += COLOR_SHARE * self.color_mismatch(person, seen, boxes[j], picture)
                specific = self.specific or bool(upright[j])
                if specific and self.fits_average_better(person, seen, boxes[j], picture):
                    cost[i, j] = np.inf
        tentative = np.array([p.number == 0 for p in people])
        found = matched(np.where(tentative[:, None], np.inf, cost), limit)
        cost[:, [box for _, box in found]] = np.inf
        return found + matched(np.where(tentative[:, None], cost, np.inf), limit)

    def _distance(
        self, person: KnownPerson, seen: BodyView, boxes: Array, gate: ValidationGate, age: float
    ) -> Array:
        """Distances of boxes (N, 4) px from a person, (N,): 1 at the limit of place or of size alone.

        They are infinite beyond the limit of size and outside the gate. age: since the person was seen, s.
        """
        shift, size = box_offsets(seen.box, boxes, self.turn)
        reach = NEAR + FAR * age
        farther = NEAR + WALK * age / max(float(seen.bearing.distance[0]), 0.1)
        change = np.abs(size[0]) / np.where(size[0] > 0, farther, reach)
        change = np.fmax(change, gate.sigmas(person, age) / GATE)
        distance = np.hypot(shift[0] / reach, change)
        return np.where((change >= 1) | gate.refused(person, age), np.inf, distance)

    def color_mismatch(self, person: KnownPerson, seen: BodyView, box: Array, picture: Picture) -> float:
        """Minus log F^C of a person, standing in a box as in the last picture; 0 if no colour is known."""
        if person.colors.evidence.sum() == 0:
            return 0.0
        return self._color_mismatch(completed(person.colors, self.relations), seen, box, picture)

    def fits_average_better(self, person: KnownPerson, seen: BodyView, box: Array, picture: Picture) -> bool:
        """Whether the average colours of people fit a box better than those of this person."""
        if person.colors.evidence.sum() == 0:
            return False
        generic = self._color_mismatch(at_large(self.relations), seen, box, picture)
        return self.color_mismatch(person, seen, box, picture) > generic

    def _color_mismatch(self, model: ColorModel, seen: BodyView, box: Array, picture: Picture) -> float:
        """Minus log F^C of a model, standing in a box as in the last picture."""
        placed = replace(seen, surface=carried(seen.surface[0], seen.box[0], box)[None])
        colors, inside = sampled(picture, placed)
        responses = feature_responses(
            colors, model.mean.astype(np.float32), model.variance.astype(np.float32)
        )
        return -float(np.log(color_likelihood(responses * inside, seen.visibility)[0]))

    def on_others(self, boxes: Boxes, box: int, taken: list[int]) -> bool:
        """Whether a box is on the body of another box. taken: numbers of the boxes that have a person."""
        return bool(
            on_body(boxes.box[[box]], boxes.box[taken], self.turn, certainties(boxes.score[[box]])).any()
        )

    def unclaimed(self, boxes: Boxes, pairs: list[tuple[int, int]], bodies: Array, least: Array) -> list[int]:
        """Boxes that initiate a person: of a sufficient score, and not on a person that is seen.

        bodies: (K, 4) px, upper bodies of people seen without a box; least: (N,) smallest scores.
        """
        claimed = [box for _, box in pairs]
        others = np.concatenate([boxes.box[claimed], bodies])
        taken = on_body(boxes.box, others, self.turn, certainties(boxes.score))
        taken |= boxes.score < least
        taken[claimed] = True
        return [int(i) for i in np.flatnonzero(~taken)]
