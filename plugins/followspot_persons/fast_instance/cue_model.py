"""How the fast instance weighs poses of people whose appearance the slow instance has learnt (section 4)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot.people import Appearances
from followspot_persons.body.shape import ShapeModel
from followspot_persons.color.difference import read_relations
from followspot_persons.color.pairs import telling_pairs
from followspot_persons.fast_instance.pose_history import propagated_contact
from followspot_persons.fast_instance.pose_tracker_params import PoseTrackerParams
from followspot_persons.likelihood.fitness import Detection, Fitness, Picture, Weights
from followspot_persons.likelihood.walkable import Walkable


@dataclass(frozen=True, eq=False)
class CueModel:
    """The shape of bodies, the weights of the cues, colour relations and the limits of space.

    pairs: of :func:`telling_pairs`; use_colors: whether learnt colours count.
    """

    shape: ShapeModel
    weights: Weights
    pairs: Array
    walkable: Walkable | None
    use_colors: bool

    @classmethod
    def of(cls, params: PoseTrackerParams, shape: ShapeModel) -> Self:
        """The model that the parameters describe. Raises InputError if a file of theirs is wrong."""
        pairs = telling_pairs(shape, read_relations(params.color_relations, shape.names))
        return cls(shape, params.weights, pairs, Walkable.within(params.walkable), params.use_colors)

    def has_features_of(self, people: Appearances) -> bool:
        """Whether the colours of the people are those of the features of this shape."""
        return bool(people.mean.shape[1] == len(self.shape.names))

    def fitness(
        self, people: Appearances, row: int, picture: Picture, time: int, detection: Detection | None = None
    ) -> Fitness:
        """The fitness of poses of one of the people in a picture of a time, ns."""
        colors = (people.mean[row].astype(np.float32), people.variance[row].astype(np.float32))
        contact = propagated_contact(people.contact[row], (time - int(people.seen[row])) * NANOSECOND)
        return Fitness(
            picture,
            self.shape,
            self.weights,
            colors=colors if self.use_colors and self.has_features_of(people) else None,
            detection=detection,
            contact=contact,
            contact_vague=contact is not None and not contact.sure,
            pairs=self.pairs,
            walkable=self.walkable,
        )
