"""Trials of real inertial sensors: their readings, and the optical path and orientation."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from followspot import Array


@dataclass(frozen=True, eq=False)
class Trial:
    """Readings and truth: N rows.

    time: (N,) s; turn_rate, specific_force: (N, 3) rad/s, m/s^2; xyz: (N, 3) m; quaternion: (N, 4); moving:
    (N,) bool.
    """

    name: str
    time: Array
    turn_rate: Array
    specific_force: Array
    xyz: Array
    quaternion: Array
    moving: Array


def read(path: Path) -> Trial:
    """A trial from its file."""
    with np.load(path, allow_pickle=False) as data:
        arrays = {name: np.asarray(data[name], float) for name in ("gyr", "acc", "opt_pos", "opt_quat")}
        rate, moving = float(data["rate"]), np.asarray(data["movement"], bool)
    time = np.arange(len(moving)) / rate
    return Trial(
        path.name[:2], time, arrays["gyr"], arrays["acc"], arrays["opt_pos"], arrays["opt_quat"], moving
    )


def truth_at(trial: Trial, times: Array) -> tuple[Array, Array]:
    """Optical position (M, 3) m and orientation (M, 4) at M times, s."""
    xyz = np.stack([np.interp(times, trial.time, column) for column in trial.xyz.T], axis=1)
    row = np.searchsorted(trial.time, times, side="right") - 1
    before, after = trial.quaternion[row], trial.quaternion[row + 1]
    after = after * np.where(np.vecdot(before, after) < 0, -1.0, 1.0)[:, None]
    share = ((times - trial.time[row]) / (trial.time[row + 1] - trial.time[row]))[:, None]
    mixed = (1 - share) * before + share * after
    return xyz, mixed / np.linalg.norm(mixed, axis=1, keepdims=True)
