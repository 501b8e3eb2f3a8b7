"""The complementary filter of orientation."""

from __future__ import annotations

import numpy as np

from followspot import Array
from followspot.rotation import turned
from followspot_imu.attitude import GRAVITY, Complementary


def inclination(force: Array) -> float:
    """Angle by which a second of a force, (3,) m/s^2, inclines an upright sensor that does not turn, rad."""
    still, filtered = np.zeros((1, 3)), Complementary(0.01, 3.0)
    filtered.update(still, np.array([[0.0, 0.0, GRAVITY]]), None)
    found = filtered.update(np.repeat(still, 100, axis=0), np.repeat(force[None], 100, axis=0), None)
    up = turned(found[-1], np.array([0.0, 0.0, 1.0]))
    return float(np.arccos(np.clip(up[2], -1, 1)))


def test_a_force_of_the_size_of_gravity_is_believed_and_a_larger_one_hardly() -> None:
    aside = np.array([np.sin(0.5), 0.0, np.cos(0.5)])
    believed, doubted = inclination(GRAVITY * aside), inclination(2 * GRAVITY * aside)
    assert 0.1 < believed < 0.2, "a third of the time constant corrects a fourth of the angle"
    assert doubted < believed / 50
