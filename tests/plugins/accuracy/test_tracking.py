"""MOTA and IDF1 on cases that are counted by hand, and against a plain count of all assignments."""

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from followspot_accuracy import PoseTable, PoseTruthTable, read_pose_truth_csv
from followspot_accuracy.persons.tracking import tracking


def truth(*ways: list[float | None]) -> PoseTruthTable:
    """Persons on the x axis, one number a frame (m), 2 m apart in y; None: absent."""
    x = np.array(ways, float).T
    pose = np.zeros((*x.shape, 6))
    pose[..., 0], pose[..., 1] = x, 2.0 * np.arange(x.shape[1])
    pose[np.isnan(x)] = np.nan
    persons = tuple(range(1, x.shape[1] + 1))
    return PoseTruthTable(persons, np.arange(len(x)) / 10, pose, np.isfinite(x).astype(float), np.zeros(2))


def poses(*rows: tuple[int, int, float, float]) -> PoseTable:
    """frame, number, x, y."""
    table = np.array(rows, float).reshape(-1, 4)
    pose = np.zeros((len(table), 6))
    pose[:, :2] = table[:, 2:]
    return PoseTable(table[:, 0] / 10, table[:, 1].astype(int), pose)


def test_a_missed_place_a_false_pose_and_a_switch_count_once_each() -> None:
    true = truth([0, 0, 0, 0, 0], [0, 0, 0, 0, None])
    found = poses(
        *((f, 7 if f < 3 else 8, 0.1, 0) for f in range(5)),  # person 1; a switch in frame 3
        *((f, 9, 0, 2) for f in (0, 1, 3)),  # person 2; missed in frame 2
        (4, 9, 0, 2),  # and gone in frame 4: false
    )
    one = tracking(found, true)
    assert (one.truths, one.missed, one.false, one.switches) == (9, 1, 1, 1)
    assert one.mota == pytest.approx(1 - 3 / 9)
    assert one.mean_m == pytest.approx(5 * 0.1 / 8)
    # Best numbers: 7 for person 1 (3 places), 9 for person 2 (3): 6 of 9 places and of 9 poses.
    assert one.idf1 == pytest.approx(2 * 6 / (9 + 9))


def test_the_truth_scores_one_and_nothing_scores_zero() -> None:
    true = truth([0, 1, 2], [3, 3, 3])
    itself = poses(*((f, p, true.pose[f, p, 0], 2.0 * p) for f in range(3) for p in (0, 1)))
    best, none = tracking(itself, true), tracking(poses(), true)
    assert (best.mota, best.idf1, best.mean_m) == (1.0, 1.0, 0.0)
    assert (none.mota, none.idf1, none.missed) == (0.0, 0.0, 6)


def test_two_poses_of_one_number_at_a_place_are_right_once() -> None:
    true = truth([0, 0, 0])
    one = tracking(poses(*((f, 1, x, 0) for f in range(3) for x in (0.0, 0.1))), true)
    assert (one.missed, one.false, one.mota) == (0, 3, 0.0)
    assert one.idf1 == pytest.approx(2 * 3 / (3 + 6))


def test_a_person_keeps_its_number_although_another_is_nearer() -> None:
    true = truth([0, 0])
    one = tracking(poses((0, 1, 0.0, 0), (1, 1, 0.4, 0), (1, 2, 0.1, 0)), true)
    assert (one.switches, one.false) == (0, 1)


def test_a_person_whose_number_went_to_somebody_else_is_found_under_another() -> None:
    """Two persons side by side had number 1 last: one of them keeps it, the other one is not missed."""
    true = truth([0.0, 0.0, 0.0])
    true = PoseTruthTable((1, 2), true.time, np.zeros((3, 2, 6)), np.ones((3, 2)), np.zeros(2))
    true.pose[:, 1, 0] = 0.4
    true.visible[0, 1] = true.visible[1, 0] = 0.0
    true.pose[0, 1] = true.pose[1, 0] = np.nan
    found = poses((0, 1, 0.0, 0), (1, 1, 0.4, 0), (2, 1, 0.35, 0), (2, 2, 0.05, 0))
    one = tracking(found, true)
    assert (one.truths, one.missed, one.false, one.switches) == (4, 0, 0, 1)


def test_persons_beyond_the_gate_are_missed() -> None:
    one = tracking(poses((0, 1, 0.51, 0)), truth([0]))
    assert (one.missed, one.false, one.mota) == (1, 1, -1.0)


def test_as_many_persons_as_possible_are_found() -> None:
    true = truth([0.0])
    true = PoseTruthTable((1, 2), true.time, np.zeros((1, 2, 6)), np.ones((1, 2)), np.zeros(2))
    true.pose[0, :, 0] = 0.0, 0.45
    one = tracking(poses((0, 1, 0.3, 0), (0, 2, 0.8, 0)), true)  # nearest first would leave one alone
    assert (one.missed, one.false) == (0, 0)


def test_outside_the_area_nothing_counts() -> None:
    true = truth([0, 0], [5, 5])
    found = poses((0, 1, 0.1, 0), (1, 1, 0.1, 0), (0, 2, 9, 9), (0, 3, 1.2, 0))
    one = tracking(found, true, (-1, -1, 1, 1))
    assert (one.truths, one.missed, one.false, one.idf1) == (2, 0, 0, 1.0)
    near = tracking(poses((0, 1, 1.2, 0), (0, 2, 0.9, 0)), truth([0.9]), (-1, -1, 1, 1))
    assert (near.missed, near.false) == (0, 1)  # a second pose of a person counts, though it is outside


def test_persons_who_are_hidden_need_not_be_found() -> None:
    true = truth([0, 0], [0, 0])
    true.visible[:, 1] = 0.2
    one = tracking(poses((0, 1, 0, 0), (1, 1, 0, 0), (0, 2, 0, 2)), true)
    assert (one.truths, one.missed, one.false, one.mota, one.idf1) == (2, 0, 0, 1.0, 1.0)


def identity_score(number: np.ndarray, persons: int) -> float:
    """IDF1 by trying all assignments. number: (F, P) numbers of right poses, -1 for none."""
    names = [int(n) for n in np.unique(number) if n >= 0]
    names += [-2] * persons
    together = [[int((number[:, p] == n).sum()) for n in names] for p in range(persons)]
    most = max(
        sum(row[c] for row, c in zip(together, way, strict=True))
        for way in permutations(range(len(names)), persons)
    )
    return 2 * most / (number.size + int((number >= 0).sum()))


def test_identities_score_as_the_best_of_all_assignments() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        number = rng.integers(-1, 3, (6, 3)) + 3 * np.arange(3) * rng.integers(0, 2)
        for row in number:  # a number is one person's at a time
            for p in range(3):
                if row[p] in row[:p]:
                    row[p] = -1
        found = poses(*((f, number[f, p], 0, 2 * p) for f in range(6) for p in range(3) if number[f, p] >= 0))
        true = truth(*[[0.0] * 6] * 3)
        assert tracking(found, true).idf1 == pytest.approx(identity_score(number, 3))


def test_truth_may_tell_places_alone(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text("time,person,x,y\n0.0,4,1.5,2\n0.1,4,1.6,2\n")
    true = read_pose_truth_csv(path)
    assert (true.persons, true.visible.tolist()) == ((4,), [[1.0], [1.0]])
    assert tracking(poses((0, 1, 1.5, 2), (1, 1, 1.6, 2)), true).mota == 1.0
