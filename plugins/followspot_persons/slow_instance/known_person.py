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
    last picture shows the background where the person would be; contact: where the person stood at the last
    update, None if the feet were not seen; sized: the same by the sizes of boxes, None before the second one,
    for the first placed the particles; stirring: how much has changed against the background; first:
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
    contact: Contact | None = None
    sized: Contact | None = None
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
            contact=contact,
            first=first,
        )

    def expected(self, seconds: float) -> KnownPerson:
        """The person where its next box is expected, some seconds after the last picture."""
        return replace(self, track=coasted(self.track, AHEAD * seconds))

    def contact_after(self, measured: Contact | None, size: Contact | None, seconds: float) -> Contact | None:
        """The floor contact some seconds later: as measured, or as the size of the body corrects it while
        the feet are hidden.

        Feet are those of another person if the last distance and the sizes of all boxes together forecast
        none that they agree with. The first feet correct sizes, which may all be wrong by one error. size:
        where the box says that the person stands, None if it says nothing.
        """
        if self.contact is None:
            return measured
        before, sizes = self.contact.later(seconds), self.sized_after(size, seconds)
        forecast = before if sizes is None else before.with_size(sizes)
        if measured is not None and measured.agrees(forecast):
            return measured
        return before if size is None else before.with_size(size)

    def sized_after(self, size: Contact | None, seconds: float) -> Contact | None:
        """Where sizes say that the person stands some seconds later; size: of a new box, None without one."""
        if self.sized is None:
            return size
        before = self.sized.later(seconds)
        return before if size is None else before.with_size(size)


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
