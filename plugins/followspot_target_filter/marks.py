"""Marks: known positions of lost targets, so that no colour has to tell them apart."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from followspot.errors import InputError, Mistake, did_you_mean
from followspot.messages import Array
from followspot.room import Camera, Room
from followspot.tracking import Forecast

SIGMA = 0.1
"""Sigma of a target's position around its mark, m."""


class Marks(NamedTuple):
    """The marks of T targets."""

    there: Array
    """(T,) bool, which have a mark."""
    xyz: Array
    """(T, 3) m, 0 without a mark."""

    def placed(self, forecast: Forecast, chosen: Array) -> Forecast:
        """The forecast with some targets at rest at their marks. chosen: (T,) bool."""
        row = chosen[:, None]
        xyz = np.where(row, self.xyz, forecast.xyz)
        return replace(
            forecast,
            xyz=xyz,
            velocity=np.where(row, 0.0, forecast.velocity),
            covariance=np.where(row[..., None], np.eye(3) * SIGMA**2, forecast.covariance),
            last=np.where(row, self.xyz, forecast.last),
            before=np.where(row, self.xyz, forecast.before),
        )


def marks_of(marks: Mapping[str, Sequence[float]], targets: Sequence[str]) -> Marks:
    """The marks of a room's targets. Raises InputError if one is that of no target."""
    for name in marks:
        if name not in targets:
            text = f'marks: the room has no target "{name}"'
            raise InputError([Mistake(None, text, did_you_mean(name, targets, "targets"))])
    positions = [marks.get(name, (0.0, 0.0, 0.0)) for name in targets]
    return Marks(np.array([name in marks for name in targets], bool), np.array(positions).reshape(-1, 3))


def indistinguishable(
    marks: Mapping[str, Sequence[float]], room: Room, cameras: Sequence[Camera]
) -> list[str]:
    """The targets that neither marks nor cameras can distinguish, in the order of the room.

    Colour distinguishes all targets, depth those of different radii. A single one is found by elimination.
    """
    kinds = {camera.kind for camera in cameras}
    if not kinds or not kinds <= {"infrared", "depth"}:
        return []
    unmarked = [name for name in room.targets if name not in marks]
    appearances = [room.targets[name].radius if "depth" in kinds else 0.0 for name in unmarked]
    return [name for name, one in zip(unmarked, appearances, strict=True) if appearances.count(one) > 1]
