"""The logarithm of a pose's weight: the likelihood of the picture (eq. 7) and the prior of poses."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from followspot import Array, Camera
from followspot.people import Boxes, Gradients
from followspot.tracking import Frame
from followspot_persons.background.floor_contact import Contact
from followspot_persons.background.illumination import in_usual_light
from followspot_persons.body.shape import ShapeModel
from followspot_persons.body.view import HEADING, HEIGHT, PAN, TILT, BodyView, pixel_index, view
from followspot_persons.color.hsi import hsi
from followspot_persons.color.likelihood import color_likelihood, feature_responses
from followspot_persons.color.pairs import difference_likelihood, pair_responses
from followspot_persons.hog.likelihood import box_likelihood, heading_log_likelihood
from followspot_persons.likelihood.certainty import certainty
from followspot_persons.likelihood.combination import gamma_operation
from followspot_persons.likelihood.edges import edge_likelihood
from followspot_persons.likelihood.walkable import Walkable
from followspot_persons.panorama import turn_of


@dataclass(frozen=True)
class Weights:
    """Weights of the cues, alpha of eq. 7; a cue of weight 0 does not count."""

    edge: float = 1.0
    color: float = 1.0
    difference: float = 0.0
    hog: float = 1.0
    gamma: float = 0.8
    """Share of the product in eq. 7."""
    color_power: float = 1.0
    """Power of F^C in a particle's weight, where alpha is no more than a constant factor of the product."""
    sharpness: float = 40.0
    """Power of eq. 7 in a particle's weight."""
    heading: float = 0.5
    """Share of a detector's log-likelihoods of headings: those of frames in a row are not independent."""
    orientation_sigma: float = 0.4
    """Sigma of an edge's orientation, rad."""
    box_width: float = 0.15
    """One sigma of the distance between box and body, in heights of the box."""
    real_valued: bool = False
    """Whether F^HOG counts in proportion to the certainty of its box."""


@dataclass(frozen=True, eq=False)
class Picture:
    """One picture of a camera, flat: magnitude and orientation (H W,) u1, colours (H W, 3) u1 BGR.

    hidden: (H W,) u1, 1 if a nearer person covers the pixel; None if no person does.
    """

    camera: Camera
    magnitude: Array
    orientation: Array
    colors: Array
    hidden: Array | None = None


def pictured(camera: Camera, frame: Frame, gradients: Gradients, light: float = 1.0) -> Picture:
    """A frame and its gradients, flat, with slightly smoothed colours; light: of the frame over the usual."""
    pixels = frame.pixels if frame.pixels.shape[2] == 3 else np.repeat(frame.pixels, 3, axis=2)
    colors = in_usual_light(cv2.blur(pixels, (3, 3)), light).reshape(-1, 3)
    return Picture(camera, gradients.magnitude.ravel(), gradients.orientation.ravel(), colors)


@dataclass(frozen=True, eq=False)
class Detection:
    """A detection of one person: box (4,) px, log-likelihoods (B,) of the headings of chest and face.

    certainty: that the box spans the upper body, 0 to 1; 0 if its size was not measured.
    """

    box: Array
    torso: Array
    head: Array
    certainty: float = 1.0

    @classmethod
    def row(cls, boxes: Boxes, row: int) -> Detection:
        """One of a detector's."""
        return cls(boxes.box[row], boxes.torso[row], boxes.head[row], certainty(float(boxes.score[row])))


@dataclass(frozen=True, eq=False)
class PosePrior:
    """The prior of a person's pose: height and its sigma (m); course (rad), the walking direction, and the
    concentration of headings about it (0: the person stands, or it is unknown).
    """

    height: float = 1.72
    height_sigma: float = 0.09
    course: float = 0.0
    concentration: float = 0.0


UNSURE_BOX = 0.5
"""F^HOG of a box that says nothing."""
UNSEEN_EDGE, UNSEEN_COLOR = 0.35, 0.45
"""Responses of features that a nearer person hides: between those of a person and of the background."""
PAN_SIGMA, TILT_SIGMA = 0.6, 0.2
"""Sigma of pan and tilt of relaxed heads, rad."""
SIDEWAYS = 0.05
"""Share of walking people whose chest does not point ahead."""


@dataclass(frozen=True, eq=False)
class Fitness:
    """Weighs poses of one person in one picture; a cue that is None does not count."""

    picture: Picture
    shape: ShapeModel
    weights: Weights
    prior: PosePrior = PosePrior()
    colors: tuple[Array, Array] | None = None
    """Mean and variance (F, 3) HSI of the surface features."""
    detection: Detection | None = None
    contact: Contact | None = None
    """Where the person stands, by the feet."""
    contact_vague: bool = False
    """Whether the last distance tells more than the contact."""
    pairs: Array | None = None
    """(2, N) of the surface features, for the colour difference."""
    walkable: Walkable | None = None
    """Where people can be; None: everywhere."""

    def __call__(self, pose: Array) -> Array:
        """Log-weights, up to a constant. pose: (P, 6). Returns (P,)."""
        seen = view(self.picture.camera, self.shape, pose)
        agreement = self.agreement(seen, self.weights.color_power)
        value = self.weights.sharpness * np.log(np.maximum(agreement, 1e-9))
        value += log_prior(pose, self.prior)
        if self.walkable is not None:
            value += self.walkable.log_prior(pose[:, :2])
        if self.contact is not None:
            away = np.hypot(*(pose[:, :2] - self.picture.camera.center[:2]).T)
            value -= 0.5 * ((away - self.contact.distance) / self.contact.sigma) ** 2
        if self.detection is not None:
            told = heading_log_likelihood(self.detection.torso, seen.bearing.torso)
            told += heading_log_likelihood(self.detection.head, seen.bearing.head)
            value += self.weights.heading * told
        return np.asarray(value)

    def likelihood(self, pose: Array) -> Array:
        """P(I | theta) of eq. 7. pose: (P, 6). Returns (P,), 0 to 1."""
        return self.agreement(view(self.picture.camera, self.shape, pose))

    def agreement(self, seen: BodyView, color_power: float = 1.0) -> Array:
        """Eq. 7 of the given cues, for bodies in view, (P,); color_power: of F^C."""
        w = self.weights
        cues = [(self.edge, w.edge)]
        if self.colors is not None:
            cues += [
                (lambda seen: np.asarray(self.color(seen) ** color_power), w.color),
                (self.difference, w.difference if self.pairs is not None else 0),
            ]
        if self.detection is not None:
            cues.append((self.box, w.hog))
        counting = [(cue, share) for cue, share in cues if share > 0]
        return gamma_operation([cue(seen) for cue, _ in counting], [share for _, share in counting], w.gamma)

    def edge(self, seen: BodyView) -> Array:
        """F^E of bodies in view, (P,)."""
        index, inside = pixel_index(self.picture.camera, seen.edge)
        hidden = self.hidden(index, inside)
        magnitude = self.picture.magnitude.take(index) * (inside & ~hidden)
        orientation = self.picture.orientation.take(index)
        likelihood = edge_likelihood(magnitude, orientation, seen.normal, self.weights.orientation_sigma)
        return np.asarray(likelihood + UNSEEN_EDGE * hidden.mean(axis=1))

    def color(self, seen: BodyView) -> Array:
        """F^C of bodies in view, (P,)."""
        assert self.colors is not None
        index, inside = pixel_index(self.picture.camera, seen.surface)
        responses = feature_responses(hsi(self.picture.colors.take(index, axis=0)), *self.colors)
        responses[self.hidden(index, inside)] = UNSEEN_COLOR
        return color_likelihood(responses * inside, seen.visibility)

    def difference(self, seen: BodyView) -> Array:
        """F^CD of bodies in view, (P,)."""
        assert self.colors is not None
        assert self.pairs is not None
        index, inside = pixel_index(self.picture.camera, seen.surface)
        shown = (inside & ~self.hidden(index, inside)) * seen.visibility
        responses = pair_responses(hsi(self.picture.colors.take(index, axis=0)), *self.colors, self.pairs)
        return difference_likelihood(responses, shown, self.pairs)

    def box(self, seen: BodyView) -> Array:
        """F^HOG of bodies in view, (P,)."""
        assert self.detection is not None
        box, turn = self.detection.box[None], turn_of(self.picture.camera)
        fit = box_likelihood(seen.box, box, self.weights.box_width, turn)
        if not self.weights.real_valued:
            return fit
        return np.asarray(UNSURE_BOX + self.detection.certainty * (fit - UNSURE_BOX))

    def hidden(self, index: Array, inside: Array) -> Array:
        """Which features at these pixels a nearer person hides."""
        if self.picture.hidden is None:
            return np.zeros(index.shape, bool)
        return np.asarray(self.picture.hidden.take(index) & inside, bool)

    def shown(self, pose: Array) -> float:
        """Share of the outline of one pose (6,) that no nearer person hides."""
        if self.picture.hidden is None:
            return 1.0
        seen = view(self.picture.camera, self.shape, pose[None])
        return float(1 - self.hidden(*pixel_index(self.picture.camera, seen.edge)).mean())


def sampled(picture: Picture, seen: BodyView) -> tuple[Array, Array]:
    """HSI of the surface features (P, F, 3), and which of them the picture shows (P, F)."""
    index, inside = pixel_index(picture.camera, seen.surface)
    if picture.hidden is not None:
        inside &= picture.hidden.take(index) == 0
    return hsi(picture.colors.take(index, axis=0)), inside


def log_prior(pose: Array, prior: PosePrior) -> Array:
    """Of height, head and the heading while walking. pose: (P, 6). Returns (P,)."""
    value = -0.5 * ((pose[:, HEIGHT] - prior.height) / prior.height_sigma) ** 2
    value -= 0.5 * (pose[:, PAN] / PAN_SIGMA) ** 2 + 0.5 * (pose[:, TILT] / TILT_SIGMA) ** 2
    if prior.concentration > 0:
        ahead = np.exp(prior.concentration * (np.cos(pose[:, HEADING] - prior.course) - 1))
        value += np.log(SIDEWAYS + (1 - SIDEWAYS) * ahead)
    return np.asarray(value)
