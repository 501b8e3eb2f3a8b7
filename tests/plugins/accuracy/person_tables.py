"""Tables of poses and truth of persons, made of positions."""

from dataclasses import replace

import numpy as np
import pytest

from followspot_accuracy import (
    PersonsScore,
    PoseTable,
    PoseTruthTable,
)

FPS = 10.0


def truth(*places: tuple[float, float], frames: int = 10) -> PoseTruthTable:
    """Persons 1, 2, ... who stand at these places, 1.7 m tall, face the room's x axis and are all visible."""
    pose = np.zeros((frames, len(places), 6))
    pose[..., :2] = np.reshape(places, (-1, 2))
    pose[..., 2] = 1.7
    persons = tuple(range(1, len(places) + 1))
    return PoseTruthTable(persons, np.arange(frames) / FPS, pose, np.ones(pose.shape[:2]), np.zeros(2))


def reported(true: PoseTruthTable, *numbers: int) -> PoseTable:
    """The truth as a tracker would report it, under these numbers."""
    frame, column = np.nonzero(np.isfinite(true.pose[..., 0]))
    person = np.array(numbers or true.persons)[column]
    return PoseTable(true.time[frame], person, true.pose[frame, column])


def shifted(poses: PoseTable, *offset: float) -> PoseTable:
    return replace(poses, pose=poses.pose + offset)


def of(poses: PoseTable, rows: np.ndarray) -> PoseTable:
    return PoseTable(poses.time[rows], poses.person[rows], poses.pose[rows])


def joined(a: PoseTable, b: PoseTable) -> PoseTable:
    return PoseTable(*(np.concatenate([getattr(a, n), getattr(b, n)]) for n in ("time", "person", "pose")))


def assert_perfect(score: PersonsScore) -> None:
    whole = score.overall
    assert whole.coverage == 1.0
    for spread in (whole.direction_deg, whole.distance_m, whole.height_cm, whole.position_cm):
        assert (spread.sigma, spread.p95) == pytest.approx((0, 0), abs=1e-9)
    assert (whole.torso.within_22, whole.torso.flipped) == (1.0, 0.0)
    assert whole.identity_switches == score.surplus.false_rows == score.surplus.duplicate_rows == 0
