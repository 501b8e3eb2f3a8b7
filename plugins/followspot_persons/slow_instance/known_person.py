"""A person that the slow instance knows: its track, colours, stature and life cycle."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from followspot import Array
from followspot.frame_times import NANOSECOND
from followspot_persons.background.existence import Stirring
from followspot_persons.background.floor_contact import Contact
from followspot_persons.body.stature import Stature
from followspot_persons.color.model import ColorModel
from followspot_persons.particles.track import Track, coasted
from followspot_persons.slow_instance.floor_distance import FloorDistance

MISSED_COST = 1.5
"""Loss of a person's trust per picture without a box."""
AHEAD = 0.5
"""Share of the forecast way after which a person is expected: people stop and turn."""


@dataclass(frozen=True, eq=False)
class KnownPerson:
    """A person of the slow instance: tentative, with number 0, until enough boxes confirm it."""

    number: int
    track: Track
    colors: ColorModel
    initiated: int
    """Time of the first box, ns."""
    seen: int
    """Time of the last box, or of the foreground that took its place, ns."""
    hits: int
    """Number of boxes."""
    trust: float
    """Sum of the boxes' scores minus the cost of missing boxes."""
    absent: bool = False
    """Whether the person has left the view."""
    boxed: int = 0
    """Time of the detector's last box, ns."""
    foreground: float | None = None
    """Mean share of the upper body that differs from the background; None while there is no background."""
    comparable: bool = False
    """Whether the person came after the background, or once differed from it, and so is no part of it."""
    stature: Stature = field(default_factory=Stature)
    left: bool = False
    """Whether the last picture shows the background where the person would be."""
    distance: FloorDistance = FloorDistance()
    """Where the person stood at the last update."""
    stirring: Stirring = Stirring()
    """How much has changed against the background."""
    first: Array | None = None
    """Picture of the first box, (H, W, 3) u1; None as soon as anything about the person has changed."""

    @classmethod
    def tentative(
        cls,
        particles: Array,
        features: int,
        score: float,
        now: int,
        *,
        comparable: bool,
        contact: Contact | None,
        first: Array | None = None,
    ) -> KnownPerson:
        """A person after one box, at one of these places (N, 6); no colour of so many features is known."""
        return cls(
            number=0,
            track=Track.initiated(particles),
            colors=ColorModel.unseen(features),
            initiated=now,
            seen=now,
            hits=1,
            trust=score,
            comparable=comparable,
            distance=FloorDistance.of(contact),
            first=first,
        )

    @property
    def contact(self) -> Contact | None:
        """Where the person most likely stood at the last update, None if the feet were not seen."""
        return self.distance.contact

    def expected(self, seconds: float) -> KnownPerson:
        """The person where its next box is expected, some seconds after the last picture."""
        return replace(self, track=coasted(self.track, AHEAD * seconds))


def missed(
    person: KnownPerson, seconds: float, now: int, longest: float, *, left: bool
) -> KnownPerson | None:
    """The person after a picture without a box; None deletes a tentative person.

    seconds: since the last picture; now: ns; longest: time without a box until a person is absent, s.
    """
    trust = person.trust - MISSED_COST
    if person.number == 0 and trust <= 0:
        return None
    absent = trust <= 0 or (now - person.seen) * NANOSECOND > longest
    track = coasted(person.track, seconds)
    return replace(person, track=track, trust=trust, absent=absent, left=left)
