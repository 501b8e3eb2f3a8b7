"""Where a person stands if some of the feet seen were those of others.

A Gaussian sum filter (Alspach & Sorenson 1972). A hypothesis says which of the feet were the person's. Feet
that agree with a hypothesis continue it; others begin a new one, as if all feet before had been those of
others. It also says whether the sizes of boxes are usual, or wrong by far more: for seconds, a
detector may take a body for one that is a third larger.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from followspot_persons.background.floor_beside import FARTHEST, NEAREST
from followspot_persons.background.floor_contact import Contact
from followspot_persons.body.stature import PROPORTION_SIGMA

OTHERS = 0.02
"""Share of first feet that are of others, or none: 2 of 102 in 52 rendered recordings."""
UNUSUAL, UNUSUAL_SIGMA = 0.05, 0.25
"""Share of people the sizes of whose boxes are far wrong, and the relative sigma of their common error. Of
3594 boxes of people in full view in 64 rendered recordings, 2 % seem nearer by a fifth or more.
"""
SHARES = {PROPORTION_SIGMA: 1 - UNUSUAL, UNUSUAL_SIGMA: UNUSUAL}
"""Probabilities of the errors that all sizes share, by their relative sigma."""
LEAST = 1e-3
"""Probability below which a hypothesis is dropped, but not the one that all feet were of others."""
MOST = 8
"""Other hypotheses that are kept."""


@dataclass(frozen=True)
class Hypothesis:
    """contact: where the person stands, None if all feet were of others; evidence: of the feet for it, in
    proportion to their density; proportion: relative sigma of the error that all sizes of boxes share.
    """

    contact: Contact | None
    evidence: float = 1.0
    proportion: float = PROPORTION_SIGMA

    def weight(self, sizes: Contact | None) -> float:
        """The evidence together with what the sizes of all boxes say, whose error is one in all pictures."""
        if self.contact is None or sizes is None:
            return self.evidence
        return self.evidence * density(self.contact, self.shared(sizes))

    def shared(self, size: Contact) -> Contact:
        """What a size, or all sizes, say with the common error of this hypothesis."""
        more = (self.proportion**2 - PROPORTION_SIGMA**2) ** 0.5
        return Contact(size.distance, float(np.hypot(size.sigma, more * size.distance)))


@dataclass(frozen=True)
class FloorDistance:
    """hypotheses: the likeliest first; sized: where the sizes of boxes say that the person stands, None
    before the second one, for the first placed the particles.
    """

    hypotheses: tuple[Hypothesis, ...] = (Hypothesis(None),)
    sized: Contact | None = None

    @classmethod
    def of(cls, contact: Contact | None) -> FloorDistance:
        """Of a person whose feet were seen first, or not."""
        if contact is None:
            return cls()
        others = OTHERS * clutter(contact)
        own = [Hypothesis(contact, (1 - OTHERS) * share, sigma) for sigma, share in SHARES.items()]
        return cls((*own, Hypothesis(None, others)))

    @property
    def contact(self) -> Contact | None:
        """Where the person most likely stands by the feet, None if the feet were not seen."""
        return self.hypotheses[0].contact

    def apparent(self, seconds: float) -> list[tuple[float, Contact]]:
        """Where the size of a box will say that the person stands some seconds later, by the feet of each
        hypothesis and all boxes so far, which share an error; and the probabilities of the hypotheses.
        """
        weight = np.array([h.weight(self.sized) for h in self.hypotheses])
        by_sizes = None if self.sized is None else self.sized.later(seconds)
        places = [_apparent(h, by_sizes, seconds) for h in self.hypotheses]
        shares = (weight / weight.sum()).tolist()
        return [(share, place) for share, place in zip(shares, places, strict=True) if place is not None]

    def later(self, measured: Contact | None, size: Contact | None, seconds: float) -> FloorDistance:
        """The same after one more picture.

        measured: by feet, None if they are not seen; size: by the box, None if it says nothing; seconds:
        since the last box.
        """
        sizes = self.sized_after(size, seconds)
        return FloorDistance(_ranked(self._continued(measured, size, sizes, seconds), sizes), sizes)

    def sized_after(self, size: Contact | None, seconds: float) -> Contact | None:
        """Where sizes say that the person stands some seconds later; size: of a new box, None without one."""
        if self.sized is None:
            return size
        before = self.sized.later(seconds)
        return before if size is None else before.with_size(size)

    def _continued(
        self, measured: Contact | None, size: Contact | None, sizes: Contact | None, seconds: float
    ) -> list[Hypothesis]:
        """Each hypothesis if these feet are of others, and the one that they are the person's."""
        if measured is None:
            return [_walked(h, size, seconds) for h in self.hypotheses]
        others, kept, own = clutter(measured), list[Hypothesis](), dict.fromkeys(SHARES, 0.0)
        for known in self.hypotheses:
            least = LEAST * others if known.contact is None else 0.0
            before = replace(known, evidence=max(known.evidence, least))
            kept.append(replace(_walked(before, size, seconds), evidence=OTHERS * others * before.evidence))
            for proportion, share in _continuing(before, measured, sizes, seconds).items():
                own[proportion] += (1 - OTHERS) * share
        return [*kept, *(Hypothesis(measured, evidence, proportion) for proportion, evidence in own.items())]


def _continuing(
    known: Hypothesis, measured: Contact, sizes: Contact | None, seconds: float
) -> dict[float, float]:
    """Evidence that feet are those of a hypothesis' person, by the error of sizes; 0 outside its gate."""
    if known.contact is None:
        return {proportion: share * known.evidence for proportion, share in SHARES.items()}
    before = known.contact.later(seconds)
    forecast = before if sizes is None else before.with_size(known.shared(sizes), known.proportion)
    likelihood = density(measured, before) if measured.agrees(forecast) else 0.0
    return {known.proportion: known.evidence * likelihood}


def _apparent(known: Hypothesis, sizes: Contact | None, seconds: float) -> Contact | None:
    """Where a box will say that somebody stands some seconds later; sizes: of all boxes."""
    if known.contact is None:
        return sizes
    walked = known.contact.later(seconds)
    expected = Contact(walked.distance, float(np.hypot(walked.sigma, known.proportion * walked.distance)))
    return expected if sizes is None else expected.combined(sizes)


def _walked(known: Hypothesis, size: Contact | None, seconds: float) -> Hypothesis:
    """A hypothesis some seconds later, when the size of a box corrects the distance while feet are hidden."""
    if known.contact is None:
        return known
    before = known.contact.later(seconds)
    if size is None:
        return replace(known, contact=before)
    return replace(known, contact=before.with_size(known.shared(size), known.proportion))


def _ranked(hypotheses: list[Hypothesis], sizes: Contact | None) -> tuple[Hypothesis, ...]:
    """The likeliest of these first, with evidence that sums to one."""
    least = LEAST * sum(h.weight(sizes) for h in hypotheses)
    none = [h for h in hypotheses if h.contact is None]
    feet = [h for h in hypotheses if h.contact is not None and h.weight(sizes) > least]
    feet.sort(key=lambda h: h.weight(sizes), reverse=True)
    kept = sorted([*feet[:MOST], *none], key=lambda h: h.weight(sizes), reverse=True)
    total = sum(h.evidence for h in kept)
    return tuple(replace(h, evidence=h.evidence / total) for h in kept)


def clutter(feet: Contact) -> float:
    """Density of the feet of others, found from `NEAREST` to `FARTHEST` of a person's distance, 1/m."""
    return 1 / ((FARTHEST - NEAREST) * feet.distance)


def density(a: Contact, b: Contact) -> float:
    """Density of the difference of two distances of one person, 1/m."""
    sigma = float(np.hypot(a.sigma, b.sigma))
    return float(np.exp(-0.5 * ((a.distance - b.distance) / sigma) ** 2) / (sigma * (2 * np.pi) ** 0.5))
