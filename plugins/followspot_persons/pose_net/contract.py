"""The interface of a pose network: images in, people with joints and scores out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np

from followspot import Array


@dataclass(frozen=True, eq=False)
class People:
    """People in one image.

    pixel: (P, J, 2) px of the image, u and v, 0 at the centre of the first pixel; certainty: (P, J) of each
    joint and score: (P,) of each person, 0 to 1.
    """

    pixel: Array
    certainty: Array
    score: Array

    def where(self, rows: Array) -> People:
        """These people, in this order."""
        return People(self.pixel[rows], self.certainty[rows], self.score[rows])


class Decoder(ABC):
    """What a family of models takes and gives. A subclass knows nothing of cameras, files or runtimes."""

    joints: ClassVar[tuple[str, ...]]
    """Names of the joints, in the order of the output; those of COCO where the joint is one of COCO's."""
    per_box: ClassVar[bool] = False
    """True if an image shows one person, cut out about a box that something else has found."""
    size: ClassVar[tuple[int, int] | None] = None
    """Width and height of the image, px; None if the model takes any multiple of `multiple`."""
    multiple: ClassVar[int] = 32
    minimum_score: ClassVar[float]
    """Score of a person below which the model's authors ignore it."""

    @abstractmethod
    def tensor(self, image: Array) -> Array:
        """The model's input from an image, (H, W, 3) u8 RGB."""

    @abstractmethod
    def people(self, outputs: Sequence[Array], size: tuple[int, int]) -> People:
        """The people in the model's outputs. size: width and height of the image, px.

        Raises ValueError if the outputs are not those of such a model.
        """


class Session(Protocol):
    """A model that is loaded."""

    @property
    def size(self) -> tuple[int, int] | None:
        """Width and height of the only image that it takes, px; None if it takes others or does not say."""

    def run(self, tensor: Array) -> Sequence[Array]:
        """The outputs. Raises ValueError if the model cannot take the input."""


@dataclass(frozen=True, eq=False)
class Network:
    """A loaded model with its decoder, shared by all cameras of a worker."""

    session: Session
    decoder: Decoder

    @property
    def size(self) -> tuple[int, int] | None:
        """Width and height of the only image that it takes, px; None if it takes others."""
        return self.session.size or self.decoder.size

    def people(self, images: Sequence[Array]) -> list[People]:
        """People in each of a batch of images, (H, W, 3) u8 RGB.

        Each image passes the model by itself: sums over a larger tensor round differently, and what is found
        in a picture must not depend on what other cameras show. Raises ValueError if the outputs are not
        those of such a model.
        """
        return [self._of_image(image) for image in images]

    def _of_image(self, image: Array) -> People:
        outputs = self.session.run(self.decoder.tensor(image))
        found = self.decoder.people(outputs, (image.shape[1], image.shape[0]))
        shapes = found.pixel.shape, found.certainty.shape, found.score.shape
        people, joints = len(found.score), len(self.decoder.joints)
        if shapes != ((people, joints, 2), (people, joints), (people,)):
            raise ValueError(f"{people} people with {joints} joints were decoded as {shapes}")
        known = np.isfinite(found.pixel).all(axis=(1, 2)) & np.isfinite(found.certainty).all(axis=1)
        return found.where(np.flatnonzero(known & np.isfinite(found.score)))


Decoders = Mapping[str, type[Decoder]]
"""Decoders by the names that users choose them by."""
