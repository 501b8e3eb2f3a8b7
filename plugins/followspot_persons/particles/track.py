"""The track of one person: particles, the smoothed pose, and the state of body and likelihood."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from followspot import Array
from followspot.geometry import wrap
from followspot_persons.background.floor_contact import Contact
from followspot_persons.body.shape import ShapeModel, with_girth
from followspot_persons.body.stature import PROPORTION_SIGMA, SPREAD, USUAL
from followspot_persons.body.view import HEADING, HEIGHT, PAN, TILT, X, Y
from followspot_persons.likelihood.fitness import Fitness, PosePrior
from followspot_persons.particles.condensation import Search, condense
from followspot_persons.particles.girth import Girth, observed
from followspot_persons.particles.unseen import Unseen

PLACE_GAIN, VELOCITY_GAIN = 0.6, 0.25
"""Share of the difference to the forecast that place and velocity take over at 15 pictures a second."""
HEADING_GAIN, HEAD_GAIN = 0.6, 0.5
"""The same of the heading, and of pan and tilt."""
RISE, FALL = 0.05, 0.01
"""Weight of a new likelihood in the typical one if it is higher, and if it is lower: a false person must not
become typical before it is noticed."""
INITIAL_TYPICAL = 0.45
"""Smallest typical likelihood of a new person."""
MINIMUM_SHOWN = 0.4
"""Smallest visible share of the outline for an update of the pose."""
FULLY_SHOWN = 0.95
"""Visible share of the outline from which the size of the body tells its distance."""
HOLD, FREE = 0.3, 1.0
"""Sigma of the speed along the line of sight, m/s: HOLD about the last speed if the person is partly hidden,
FREE about 0 otherwise."""
MAXIMUM_SPEED = 2.0
"""Of a person in a room, m/s."""
PERIOD = 1 / 15
"""Period of the pictures that the gains refer to, s."""
SCALE_SIGMA = 0.06
"""Relative sigma of a distance from a body's size in one picture."""
WALKING, STRIDING = 0.25, 0.6
"""Speeds at which the course begins to determine the heading, and does so fully, m/s."""
CONCENTRATION = 8.0
"""Concentration of headings about the course of a walking person."""


@dataclass(frozen=True, eq=False)
class Track:
    """particles: (N, 6); pose, sigma: (6,), smoothed; velocity: (2,) m/s; stature: (2,) the person's height
    and its sigma, m; likelihood: of the pose in the last picture (eq. 7); typical: its slow mean; shown:
    share of the outline that no nearer person hides; unseen: for how long pictures have not told the place;
    sigma is that of the last picture that did.
    """

    particles: Array
    pose: Array
    sigma: Array
    velocity: Array
    stature: tuple[float, float] = (USUAL, SPREAD)
    girth: Girth = field(default_factory=Girth.unknown)
    likelihood: float = 0.0
    typical: float = 0.0
    shown: float = 1.0
    unseen: Unseen = Unseen()

    @classmethod
    def initiated(cls, particles: Array) -> Track:
        """A new person with these particles."""
        pose = particles.mean(axis=0)
        return cls(particles, pose, particles.std(axis=0), np.zeros(2))

    def resumed(self, particles: Array) -> Track:
        """The same person after an absence, at one of these places: the body is still known."""
        return replace(
            Track.initiated(particles),
            stature=self.stature,
            girth=self.girth,
            typical=self.typical,
        )

    def with_spawned(self, particles: Array) -> Track:
        """The track with these particles in place of as many of its own."""
        return replace(self, particles=np.concatenate([self.particles[len(particles) :], particles]))

    def present_sigma(self, eye: Array) -> Array:
        """Sigma of the pose (6,), which grows while pictures do not tell the place; eye: (3,) m, the
        camera's centre.
        """
        out = self.sigma.copy()
        out[[X, Y]] = np.hypot(out[[X, Y]], self.unseen.sigma(self.pose[[X, Y]] - eye[:2]))
        return out

    @property
    def prior(self) -> PosePrior:
        """The prior of the next pose from the person's past."""
        speed = float(np.hypot(*self.velocity))
        walking = float(np.clip((speed - WALKING) / (STRIDING - WALKING), 0, 1))
        course = float(np.arctan2(self.velocity[1], self.velocity[0]))
        return PosePrior(*self.stature, course, CONCENTRATION * walking)


def updated(
    track: Track,
    seconds: float,
    fitness: Fitness,
    bodies: ShapeModel,
    search: Search,
    rng: np.random.Generator,
) -> Track:
    """The track after one more picture.

    seconds: since the last one; fitness: of this picture, to be used with the person's own shape and prior;
    bodies: of :func:`girths_of`.
    """
    eye = fitness.picture.camera.center
    own = replace(fitness, shape=with_girth(fitness.shape, track.girth.mean), prior=track.prior)
    if track.likelihood:
        own = replace(own, contact=_distance_before(track, seconds, own))
    particles, estimate = condense(track.particles, track.velocity, seconds, own, eye, search, rng)
    value = float(replace(own, detection=None).likelihood(estimate.pose[None])[0])
    shown = own.shown(estimate.pose)
    if shown < MINIMUM_SHOWN:
        return replace(coasted(track, seconds), particles=particles, likelihood=value, shown=shown)
    told = own.contact is not None and own.contact is fitness.contact
    unseen = track.unseen.after(seconds, distance=told or shown >= FULLY_SHOWN, direction=True)
    girth = observed(track.girth, own, bodies, estimate.pose)
    measured = _with_stature(estimate.pose, *track.stature, eye, own.contact)
    forecast = track.pose.copy()
    forecast[[X, Y]] += track.velocity * seconds
    pose, velocity = _smoothed(forecast, track.velocity, measured, seconds, fresh=not track.likelihood)
    typical = track.typical or max(value, INITIAL_TYPICAL)
    typical += (RISE if value > typical else FALL) * (value - typical)
    sigma = _total_sigma(estimate.sigma, pose, track.stature[1], eye, fitness.contact)
    return Track(particles, pose, sigma, velocity, track.stature, girth, value, typical, shown, unseen)


def _distance_before(track: Track, seconds: float, fitness: Fitness) -> Contact:
    """Where a person stands by what is known beside the picture's edges and colours.

    Feet tell it. Without them it is as in the last picture, for people walk a metre a second and one
    picture's size says little; what feet told earlier counts beside it. If the person is partly hidden, it
    goes on as it did.
    """
    eye, told = fitness.picture.camera.center, fitness.contact
    if told is not None and not fitness.contact_vague:
        return told
    hidden = fitness.shown(track.pose) < FULLY_SHOWN
    there = track.pose[[X, Y]] - eye[:2] + (track.velocity * seconds if hidden else 0.0)
    last = Contact(float(np.hypot(*there)), (HOLD if hidden else FREE) * max(seconds, PERIOD))
    return last if hidden or told is None else last.combined(told)


def _with_stature(pose: Array, stature: float, sigma: float, eye: Array, contact: Contact | None) -> Array:
    """The pose with the person's height, known to `sigma` m, at the distance where the head's top stays in
    place.

    If the head is about as high as the camera, its image does not depend on the distance, which then stays.
    """
    above = _height_above(pose, eye)
    by_size = 1 / (1 / (SCALE_SIGMA**2 + PROPORTION_SIGMA**2) + _by_feet(pose, eye, contact))
    share = by_size / (by_size + (sigma / above) ** 2)
    out = pose.copy()
    out[[X, Y]] += share * (stature - pose[HEIGHT]) / above * (pose[[X, Y]] - eye[:2])
    out[HEIGHT] = stature
    return out


def _by_feet(pose: Array, eye: Array, contact: Contact | None) -> float:
    """Precision of the distance by the feet, relative to the distance."""
    return 0.0 if contact is None else float(np.sum((pose[:2] - eye[:2]) ** 2)) / contact.sigma**2


def _total_sigma(spread: Array, pose: Array, sigma: float, eye: Array, contact: Contact | None) -> Array:
    """Sigma of a pose (6,): the spread of the particles (6,) and the errors that all pictures share.

    The height is known to `sigma` m, and the distance no better than height or proportions give it. The
    height came from the size, too, so that the two are one piece of evidence.
    """
    away = pose[[X, Y]] - eye[:2]
    by_size = max(PROPORTION_SIGMA**-2, (_height_above(pose, eye) / sigma) ** 2)
    precision = by_size + _by_feet(pose, eye, contact)
    out = spread.copy()
    out[[X, Y]] = np.hypot(spread[[X, Y]], away * precision**-0.5)
    out[HEIGHT] = np.hypot(spread[HEIGHT], sigma)
    return out


def _height_above(pose: Array, eye: Array) -> float:
    """Height of the head's top over the camera, m, never quite 0."""
    above = float(pose[HEIGHT] - eye[2])
    return float(np.copysign(max(abs(above), 1e-3), above))


def coasted(track: Track, seconds: float) -> Track:
    """The track after some time without measurements."""
    pose = track.pose.copy()
    pose[[X, Y]] += track.velocity * seconds
    unseen = track.unseen.after(seconds, distance=False, direction=False)
    return replace(
        track, pose=pose, velocity=track.velocity * np.exp(-seconds), likelihood=0.0, unseen=unseen
    )


def _smoothed(
    forecast: Array, velocity: Array, measured: Array, seconds: float, *, fresh: bool
) -> tuple[Array, Array]:
    """The g-h filter of the place, and exponential smoothing of the angles; gains scale with the time."""
    if fresh:
        return measured.copy(), velocity
    scale = seconds / PERIOD
    gain = np.array([PLACE_GAIN] * 3 + [HEADING_GAIN] + [HEAD_GAIN] * 2)
    gain = 1 - (1 - gain) ** max(scale, 1e-3)
    difference = measured - forecast
    difference[HEADING] = wrap(difference[HEADING])
    pose = forecast + gain * difference
    if abs(difference[HEADING]) > np.pi / 2:
        pose[[HEADING, PAN, TILT]] = measured[[HEADING, PAN, TILT]]
    pose[HEADING], pose[HEIGHT] = wrap(pose[HEADING]), measured[HEIGHT]
    if seconds > 0:
        share = 1 - (1 - VELOCITY_GAIN) ** scale
        velocity = velocity + share * difference[[X, Y]] / max(seconds, PERIOD)
        velocity = velocity * min(1.0, MAXIMUM_SPEED / max(float(np.hypot(*velocity)), 1e-9))
    return pose, velocity
