"""Readings in units and axes of other programs, in those of `followspot.inertial.Inertial`."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import field_validator

from followspot import Array, Field, StageParams
from followspot.rotation import signed_axes

TURN, FORCE, MAGNETIC = ("gx", "gy", "gz"), ("ax", "ay", "az"), ("mx", "my", "mz")
VALUES = (*TURN, *FORCE, *MAGNETIC)
"""Names of the values of a reading: gyroscope, accelerometer and magnetometer, in this order."""
MOST = np.repeat([100.0, 10_000.0, 100_000.0], 3)
"""Largest absolute value of each, rad/s, m/s^2 and uT: gyroscopes of props read up to 70 rad/s."""
FORCE_AT_REST = (5.0, 20.0)
"""Between these the median force of a sensor lies that is moved by hand, m/s^2; at rest it is 9.8."""
FULL_RANGE = 35.0
"""Turn rate that few readings of a prop exceed, rad/s: 2000 deg/s, the range of most gyroscopes."""
DEGREE = np.pi / 180
STANDARD_GRAVITY = 9.80665
"""m/s^2 in a g."""
_TURN = {"rad/s": 1.0, "deg/s": DEGREE, "mdeg/s": DEGREE / 1000}
_FORCE = {"m/s^2": 1.0, "g": STANDARD_GRAVITY, "mg": STANDARD_GRAVITY / 1000}
_FIELD = {"uT": 1.0, "nT": 0.001, "mT": 1000.0, "T": 1e6, "mG": 0.1, "G": 100.0}


class AxesParams(StageParams):
    """How the sensor is mounted."""

    axes: str = Field(
        "x y z",
        pattern=r"^-?[xyz] -?[xyz] -?[xyz]$",
        description="axes of the readings that are the target's x, y and z: y -x z if it is mounted turned",
    )

    @field_validator("axes")
    @classmethod
    def _check_axes(cls, value: str) -> str:
        if np.linalg.det(signed_axes(value)) < 0:
            raise ValueError("the axes must be right-handed: change one sign, or swap two")
        return value


class UnitParams(AxesParams):
    """The units and the axes of the readings."""

    turn_unit: Literal["rad/s", "deg/s", "mdeg/s"] = Field("rad/s", description="unit of the gyroscope")
    force_unit: Literal["m/s^2", "g", "mg"] = Field("m/s^2", description="unit of the accelerometer")
    field_unit: Literal["uT", "nT", "mT", "T", "mG", "G"] = Field(
        "uT", description="unit of the magnetometer"
    )
    at_rest: Literal["up", "down"] = Field(
        "up", description="where the accelerometer's reading points at rest; down for one that reads gravity"
    )

    @property
    def scale(self) -> Array:
        """(9,): from the given units to those of a reading."""
        force = _FORCE[self.force_unit] * (1.0 if self.at_rest == "up" else -1.0)
        return scale_of(_TURN[self.turn_unit], force, _FIELD[self.field_unit])


def scale_of(turn: float, force: float, magnetic: float) -> Array:
    """(9,): factors of the three kinds of values, from other units to those of a reading."""
    return np.repeat([turn, force, magnetic], 3)


def converted(values: Array, scale: Array, axes: str) -> tuple[Array, Array, Array]:
    """Turn rate, specific force and field, (N, 3) each. values: (N, 9) in the order of `VALUES`."""
    turned = (values * scale).reshape(-1, 3, 3) @ signed_axes(axes).T
    return turned[:, 0], turned[:, 1], turned[:, 2]


def doubts_of_units(turn_rate: Array, force: Array) -> dict[str, str]:
    """Why readings (N, 3) rad/s and m/s^2 are hardly in the units that were said, by the parameter."""
    doubts = {"force_unit": _doubt_of_force(force), "turn_unit": _doubt_of_turn(turn_rate)}
    return {parameter: doubt for parameter, doubt in doubts.items() if doubt}


def _doubt_of_turn(turn_rate: Array) -> str:
    """Why turn rates (N, 3) rad/s are hardly in the unit that was said, "" if they may be."""
    size = float(np.percentile(np.linalg.norm(turn_rate, axis=1), 95)) if len(turn_rate) else 0.0
    if size <= FULL_RANGE:
        return ""
    return (
        f"the gyroscope reads {size:.3g} rad/s and more in a twentieth of the time, which is fast for a prop"
    )


def _doubt_of_force(force: Array) -> str:
    """Why readings (N, 3) m/s^2 are hardly in the unit that was said, "" if they may be."""
    size = float(np.median(np.linalg.norm(force, axis=1))) if len(force) else 0.0
    if not size or FORCE_AT_REST[0] <= size <= FORCE_AT_REST[1]:  # zeros are those of a gyroscope alone
        return ""
    return f"the accelerometer reads {size:.3g} m/s^2 at the median, where a sensor at rest reads 9.8"
