"""The message of the slow instance to the fast one about the people that it knows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from followspot.people import Appearances
from followspot_persons.background.illumination import Illumination
from followspot_persons.color.difference import ColorRelations, completed
from followspot_persons.slow_instance.known_person import KnownPerson


def reported(
    people: Sequence[KnownPerson],
    camera: str,
    features: int,
    relations: ColorRelations | None,
    illumination: Illumination,
) -> Appearances:
    """The message about the people who have numbers.

    features: of the shape's surface; relations: predict the colours of unseen sides, unless None.
    """
    known = sorted((p for p in people if p.number), key=lambda p: p.number)
    models = [p.colors if relations is None else completed(p.colors, relations) for p in known]
    contacts = [(0.0, 0.0) if (c := p.contact) is None else (c.distance, c.sigma**-2) for p in known]
    return Appearances(
        camera=camera,
        person=np.array([p.number for p in known], np.int32),
        mean=np.array([m.mean for m in models]).reshape(-1, features, 3),
        variance=np.array([m.variance for m in models]).reshape(-1, features, 3),
        evidence=np.array([m.evidence for m in models]).reshape(-1, features),
        pose=np.array([p.track.pose for p in known]).reshape(-1, 6),
        stature=np.array([p.track.stature for p in known]).reshape(-1, 2),
        contact=np.array(contacts).reshape(-1, 2),
        seen=np.array([p.seen for p in known], np.int64),
        left=np.array([p.left for p in known], np.uint8),
        light=illumination.light,
    )
