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
    """A person of the slow instance: tentative, with number 0, until enough boxes confirm it.

    initiated, seen: ns, times of the first and of the last box; hits: number of boxes; trust: sum of their
    scores minus the cost of missing boxes; absent: whether the person has left; boxed: ns, time of the
    detector's last box (the foreground alone may move `seen` beyond it); foreground: mean share of the
    upper body that differs from the background, None while there is no background; comparable: whether the
    person came after the background, or once differed from it, and so is no part of it; left: whether the
    last picture shows the background where the person would be; distance: where the person stood at the last
    update; stirring: how much has changed against the background; first:
    (H, W, 3) u1, picture of the first box, as long as nothing about the person has changed since, then None.
    """

    number: int
    track: Track
    colors: ColorModel
    initiated: int
    seen: int
    hits: int
    trust: float
    absent: bool = False
    boxed: int = 0
    foreground: float | None = None
    comparable: bool = False
    stature: Stature = field(default_factory=Stature)
    left: bool = False
    distance: FloorDistance = FloorDistance()
    stirring: Stirring = Stirring()
    first: Array | None = None

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
