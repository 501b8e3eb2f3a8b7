"""Stages that refuse or change what they must take: parameters, inputs, pictures of any size."""

from __future__ import annotations

import numpy as np
from pydantic import ConfigDict

from followspot import Latest, Stage, StageParams, Window
from followspot.tracking import Blobs, Forecast, Frame


class LooseParams(StageParams):
    model_config = ConfigDict(extra="ignore", frozen=False)


class Loose(Stage):
    """Takes any parameter."""

    Params = LooseParams  # type: ignore[assignment]

    def process(self, blobs: Blobs) -> Blobs:
        return blobs


class Writing(Stage):
    """Unlocks the arrays of others."""

    def process(self, blobs: Blobs) -> Blobs:
        object.__setattr__(blobs, "area", blobs.area + 1)
        return blobs


class Unreadable(Exception):
    def __str__(self) -> str:
        raise LookupError


class Speechless(Stage):
    """Raises what says nothing."""

    def process(self, blobs: Blobs) -> Blobs:
        raise Unreadable


class Untyped(Stage):
    """Does not say what it takes."""

    def process(self, blobs) -> Blobs:  # type: ignore[no-untyped-def]
        return blobs


class WindowWriter(Stage):
    """Changes a message of its window."""

    def process(self, blobs: Blobs, window: Window[Blobs] = ()) -> Blobs:
        for other in window:
            object.__setattr__(other, "area", other.area + 1)
        return blobs


class NotANumber(Stage):
    """Trusts its input."""

    def process(self, forecast: Forecast) -> Forecast:
        forecast.xyz.astype(int)
        if np.isnan(forecast.xyz).any():
            raise ValueError("not a number")
        return forecast


class Late(Stage):
    """Trusts the clock."""

    last = -1

    def process(self, blobs: Blobs) -> Blobs:
        if blobs.header.time <= self.last:
            raise ValueError("time goes back")
        self.last = blobs.header.time
        return blobs


class SmallPicture(Stage):
    """Trusts the size of pictures."""

    def process(self, frame: Frame) -> Frame:
        return Frame(frame.camera, frame.pixels[20:21, 20:21] // frame.pixels[20, 20].shape)


class Lonely(Stage):
    """Needs what is only held."""

    def process(self, blobs: Blobs, forecast: Latest[Forecast] = None) -> Blobs:
        return blobs.where(np.arange(len(forecast.xyz)))  # type: ignore[union-attr]
