"""Where a person stands: the lowest foreground below the body, and the height that follows from it.

A camera above the floor knows the distance of a point on the floor. Feet are nearer to the camera than the
axis of the body, by half a foot and half a step.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from followspot import Array
from followspot_persons.background.body_axis import Axis, distance_on_floor
from followspot_persons.background.ghost import is_ghost
from followspot_persons.background.goes_on import goes_on_below
from followspot_persons.background.scene import Scene
from followspot_persons.body.standing import knows_floor, rise
from followspot_persons.body.stature import PROPORTION_SIGMA
from followspot_persons.body.view import HEIGHT

WIDTH = 0.3
"""Half the width of the searched strip, in heights of the upper body."""
SHARE = 0.06
"""Share of a row of the strip that is foreground where a leg is."""
GAP = 0.1
"""Longest gap between two rows of legs, in heights of the upper body: a belt, a bare ankle."""
STRIDE_SIGMA = 0.15
"""Sigma of a distance from the feet, m: the nearer foot of a walker is up to half a step before the axis."""
WALK = 1.0
"""Growth of the sigma of a distance with its age, m/s."""
GATE = 2.0
"""Largest difference between two distances of the same person, in sigmas: 95 % of a Gaussian."""
LARGEST_CHANGE = 0.25
"""Difference of the distance from that by size, relative, up to which both are of one body. Feet farther away
are none: furniture hides the legs. Feet much nearer are those of a person whose head or chest alone was taken
for the upper body.
"""
BODY = 0.6
"""Share of the upper half of the strip's middle that is foreground where a person is."""
BESIDE = 0.45
"""Half the width of another person's columns, in heights of its upper body."""
LEGS, FEET = 0.7, 0.25
"""Heights above the lowest row in which no ghost may be, in heights of the upper body: beside a ghost's feet
stand the legs of the person, whose edges are stronger.
"""
ASTRIDE = 0.6
"""Reach of a foot beside the strip, in heights of the upper body: half a long step."""
FREE = 0.5
"""Share of the strip that nearer people must leave."""
ROUNDS = 4
"""Of looking for the feet, for a nearer person has a wider strip."""


@dataclass(frozen=True)
class Contact:
    """Where a person stands: horizontal distance from the camera, and its sigma, m."""

    distance: float
    sigma: float = STRIDE_SIGMA

    @property
    def sure(self) -> bool:
        """Whether it is as sure as by feet of the same picture."""
        return self.sigma <= STRIDE_SIGMA

    def later(self, seconds: float) -> Contact:
        """The same some seconds later, when the person may have walked."""
        return Contact(self.distance, float(np.hypot(self.sigma, WALK * seconds)))

    def combined(self, other: Contact) -> Contact:
        """What two distances of independent errors say together."""
        gain = self.sigma**2 / (self.sigma**2 + other.sigma**2)
        return Contact(
            self.distance + gain * (other.distance - self.distance), self.sigma * (1 - gain) ** 0.5
        )

    def with_size(self, size: Contact, proportion: float = PROPORTION_SIGMA) -> Contact:
        """The same after a picture in which the size of the body says that it stands there.

        The error of its proportions is one in all pictures: sizes tell no distance better than to the
        relative sigma `proportion`, as in the filter of Schmidt (1966).
        """
        both = self.combined(size)
        surest = min(self.sigma, proportion * both.distance)
        return Contact(both.distance, max(both.sigma, surest))

    def agrees(self, other: Contact) -> bool:
        """Whether both can be of one person."""
        return abs(self.distance - other.distance) <= GATE * float(np.hypot(self.sigma, other.sigma))


@dataclass(frozen=True)
class Presence:
    """What the background tells of a person: share of foreground in the middle of the upper body, and of a
    strip about it that holds its outline; height by the feet, m, and distance by the feet, both None if they
    are not seen on the floor.
    """

    foreground: float
    about: float
    height: float | None = None
    contact: Contact | None = None


def presence(scene: Scene | None, pose: Array, others: Array) -> Presence | None:
    """Compare a person with the background; None if it is unknown, or if the person has no image.

    pose: (6,); others: (K, 4) px, upper bodies of nearer people, whose columns say nothing of this person.
    """
    first = None if scene is None else _Strip.of(scene, pose, others)
    if scene is None or first is None:
        return None
    strip: _Strip | None = first
    eye = scene.camera.center
    for _ in range(ROUNDS if knows_floor(scene.camera) else 0):
        distance = None if strip is None else strip.distance(scene)
        by_size = float(np.hypot(*(pose[:2] - eye[:2])))
        if strip is None or distance is None or distance > (1 + LARGEST_CHANGE) * by_size:
            break
        head = strip.axis.head
        height = float(eye[2] + rise(scene.camera, head[:1], head[1:])[0] * distance)
        if distance >= (1 - LARGEST_CHANGE) * by_size:
            return Presence(first.body, first.about, height, Contact(distance))
        # The pose is of a head or chest alone: look for the feet of a body as near and tall as these say.
        pose = moved(pose, eye, distance, height)
        strip = _Strip.of(scene, pose, others)
    return Presence(first.body, first.about)


def moved(pose: Array, eye: Array, distance: float, height: float) -> Array:
    """A pose (6,) at another distance in the same direction, of another height, m."""
    away = pose[:2] - eye[:2]
    out = pose.copy()
    out[:2] = eye[:2] + away * distance / np.hypot(*away)
    out[HEIGHT] = height
    return out


@dataclass(frozen=True, eq=False)
class _Strip:
    """Foreground along the axis of a body from head to below the feet.

    rows: (R,); columns: (R, C); changed, free: (R, C) bool, foreground, and what no nearer person hides;
    others: (K, 4) px, upper bodies of nearer people; body, about: share of foreground in the middle of the
    upper body, and in all columns of its rows.
    """

    axis: Axis
    rows: Array
    columns: Array
    changed: Array
    free: Array
    others: Array
    body: float
    about: float

    @classmethod
    def of(cls, scene: Scene, pose: Array, others: Array) -> _Strip | None:
        """The strip about a pose (6,); None if it is not upright, or its upper body not in the picture."""
        axis = Axis.of(scene.camera, pose)
        if axis is None:
            return None
        last = min(scene.camera.size[1], int(axis.foot[1] + 0.5 * (axis.foot[1] - axis.head[1])))
        rows = np.arange(max(0, int(axis.head[1])), max(last, 1))
        half = int(WIDTH * axis.tall)
        columns = axis.beside(rows, half)
        middle = np.abs(np.arange(-half, half + 1)) <= half / 3
        changed = scene.changed(rows[:, None], columns)
        upper = changed[rows < axis.waist[1]]
        free = scene.beside(columns, others, BESIDE)
        if not upper.size:
            return None
        shares = float(upper[:, middle].mean()), float(upper.mean())
        return cls(axis, rows, columns, changed, free, others, *shares)

    @property
    def gap(self) -> int:
        """Longest gap between two rows of legs, px."""
        return max(1, round(GAP * self.axis.tall))

    def distance(self, scene: Scene) -> float | None:
        """Horizontal distance of the person from the camera by the feet, m; None if they are not seen."""
        low = self.lowest(scene)
        return None if low is None else distance_on_floor(scene.camera, self.axis, low)

    def lowest(self, scene: Scene) -> int | None:
        """The lowest row of the person. None if no person is there, if a nearer person hides too much, if the
        legs are those of a ghost, or if they continue beside the strip.
        """
        if self.body < BODY or self.free.mean() < FREE:
            return None
        filled = (self.changed & self.free).sum(axis=1) >= SHARE * self.free.shape[1]
        last = lowest(filled, self.gap)
        ghost = any(self.ghost(scene, last, share) for share in (LEGS, FEET))
        return None if ghost or self.astride(scene, last) else int(self.rows[last])

    def ghost(self, scene: Scene, last: int, share: float) -> bool:
        """Whether a ghost is in the rows above the last one, up to a share of the upper body's height."""
        legs = slice(max(0, last + 1 - round(share * self.axis.tall)), last + 1)
        there = self.rows[legs, None], self.columns[legs] % scene.camera.size[0]
        return is_ghost(self.changed[legs], scene.pixels[there], scene.background[there], scene.light)

    def astride(self, scene: Scene, last: int) -> bool:
        """Whether legs leave the strip at its side: their foreground goes on below its lowest row, of this
        index, so that this row is of a knee.
        """
        reach, first = round(ASTRIDE * self.axis.tall), max(0, last - self.gap)
        rows, width = self.rows[first : last + 1 + reach], self.columns.shape[1]
        columns = self.axis.beside(rows, width // 2 + reach)
        changed = scene.changed(rows[:, None], columns) & scene.beside(columns, self.others, BESIDE)
        strip = slice(0, last + 1 - first), slice(reach, reach + width)
        return goes_on_below(changed, strip, self.gap)


def lowest(filled: Array, gap: int) -> int:
    """Last of the rows (R,) bool that are filled from the first filled one on, without a longer gap."""
    found = np.flatnonzero(filled)
    if not len(found):
        return 0
    breaks = np.flatnonzero(np.diff(found) > gap)
    return int(found[breaks[0]] if len(breaks) else found[-1])
