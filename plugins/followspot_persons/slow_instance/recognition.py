"""Re-identification: which confirmed newcomer is an absent person that has returned (sections 3.3 and 5)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot.frame_times import NANOSECOND
from followspot_persons.body.stature import USUAL
from followspot_persons.color.difference import ColorRelations
from followspot_persons.slow_instance.identity import same_person
from followspot_persons.slow_instance.known_person import KnownPerson

UNUSUAL_HEIGHT = 0.12
"""Difference from the mean height that raises the confirmation score of a newcomer by half a point, m."""
LIKENESS_MARGIN = 1.5
"""A newcomer waits for a number if its likeness to a lost person is no farther below `minimum_likeness`."""
MAXIMUM_WAIT = 1.5
"""Longest time that it waits, s: two pictures hardly tell the colours of a person."""


@dataclass(frozen=True, eq=False)
class Recognition:
    """confirmation_score, minimum_likeness: parameters of `persons.appearance`; relations: of colours."""

    confirmation_score: float
    minimum_likeness: float
    relations: ColorRelations

    def applied(self, people: list[KnownPerson], numbers: int) -> tuple[list[KnownPerson], int]:
        """All persons, and how many numbers were given: confirmed newcomers get the number of an absent
        person of the same appearance, or a new one. A newcomer that may be an absent person waits for its
        number, and stays tentative until then.
        """
        newcomers = [p for p in people if self.confirmed(p)]
        others = [p for p in people if not self.confirmed(p)]
        for newcomer in newcomers:
            known, likeness = self.likeliest(newcomer, others)
            if known is not None and likeness >= self.minimum_likeness:
                others = [p for p in others if p is not known]
                others.append(resumed(known, newcomer))
            elif likeness >= self.minimum_likeness - LIKENESS_MARGIN and waited(newcomer) < MAXIMUM_WAIT:
                others.append(newcomer)
            else:
                numbers += 1
                others.append(replace(newcomer, number=numbers))
        return others, numbers

    def confirmed(self, person: KnownPerson) -> bool:
        """Whether a tentative person is confirmed: by boxes, and because it stirred."""
        unusual = 0.5 * ((person.stature.by_size - USUAL) / UNUSUAL_HEIGHT) ** 2
        if person.number or person.first is not None:
            return False
        return person.hits > 1 and person.trust >= self.confirmation_score + unusual

    def likeliest(self, newcomer: KnownPerson, others: list[KnownPerson]) -> tuple[KnownPerson | None, float]:
        """The person, lost before the newcomer appeared, that it most likely is, and the log-likelihood ratio
        of :meth:`likeness`. Returns None and minus infinity if no person was lost.
        """
        lost = [p for p in others if p.number and p.seen < newcomer.initiated]
        if not lost:
            return None, -np.inf
        likeness = [self.likeness(newcomer, p) for p in lost]
        best = int(np.argmax(likeness))
        return lost[best], likeness[best]

    def likeness(self, a: KnownPerson, b: KnownPerson) -> float:
        """Log of how much likelier two known persons are one than two."""
        return same_person(a.colors, b.colors, (a.stature.estimate[0], b.stature.estimate[0]), self.relations)


def waited(newcomer: KnownPerson) -> float:
    """Time from the first box of a newcomer to its last one, s."""
    return (newcomer.seen - newcomer.initiated) * NANOSECOND


def resumed(known: KnownPerson, newcomer: KnownPerson) -> KnownPerson:
    """A known person at the place of a newcomer."""
    track = replace(known.track.resumed(newcomer.track.particles), pose=newcomer.track.pose)
    return replace(newcomer, number=known.number, colors=known.colors, stature=known.stature, track=track)
