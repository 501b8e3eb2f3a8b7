"""Quaternions against rotation matrices of OpenCV."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from followspot.rotation import (
    angle_between,
    canonical,
    cross,
    from_rotation_vector,
    inverse,
    matrix,
    multiply,
    rotation_vector,
    turned,
)

VECTORS = np.random.default_rng(4).uniform(-1.7, 1.7, (50, 3))
QUATERNIONS = from_rotation_vector(VECTORS)
MATRICES = np.array([cv2.Rodrigues(vector)[0] for vector in VECTORS])


def test_a_quaternion_turns_as_its_matrix_does() -> None:
    v = VECTORS[::-1]
    assert np.allclose(matrix(QUATERNIONS), MATRICES)
    assert np.allclose(turned(QUATERNIONS, v), (MATRICES @ v[..., None])[..., 0])


def test_a_product_turns_by_the_right_one_first() -> None:
    product = multiply(QUATERNIONS[:-1], QUATERNIONS[1:])
    assert np.allclose(matrix(product), MATRICES[:-1] @ MATRICES[1:])
    assert np.allclose(multiply(QUATERNIONS, inverse(QUATERNIONS)), [1, 0, 0, 0])


def test_a_rotation_vector_is_read_back_also_of_the_negative_quaternion() -> None:
    assert np.allclose(rotation_vector(QUATERNIONS), VECTORS)
    assert np.allclose(rotation_vector(-QUATERNIONS), VECTORS)
    for tiny in (0.0, 1e-20, 1e-9):
        vector = np.array([tiny, 0.0, 0.0])
        assert np.allclose(rotation_vector(from_rotation_vector(vector)), vector, rtol=1e-9, atol=0)


def test_the_angle_between_two_rotations_is_that_of_the_way_from_one_to_the_other() -> None:
    turn = from_rotation_vector(np.array([0.0, 0.3, 0.0]))
    assert np.allclose(angle_between(QUATERNIONS, multiply(QUATERNIONS, turn)), 0.3)
    assert np.allclose(angle_between(QUATERNIONS, -QUATERNIONS), 0.0)


def test_the_canonical_quaternion_has_length_one_and_a_positive_first_number() -> None:
    found = canonical(np.array([[-2.0, 0.0, 0.0, 2.0], [0.0, 3.0, 0.0, 0.0]]))
    assert np.allclose(found, [[np.sqrt(0.5), 0, 0, -np.sqrt(0.5)], [0, 1, 0, 0]])


def test_what_is_not_known_stays_so() -> None:
    unknown = np.full((1, 4), np.nan)
    assert np.isnan(canonical(unknown)).all()
    assert np.isnan(rotation_vector(unknown)).all()
    assert np.isnan(turned(unknown, np.ones((1, 3)))).all()


@pytest.mark.parametrize("shapes", [((3,), (3,)), ((4, 1, 3), (4, 2, 3)), ((3,), (5, 3))])
def test_a_cross_product_is_that_of_numpy_bit_for_bit(
    shapes: tuple[tuple[int, ...], tuple[int, ...]],
) -> None:
    a, b = (np.random.default_rng(seed).normal(size=shape) for seed, shape in enumerate(shapes))
    np.testing.assert_array_equal(cross(a, b), np.cross(a, b))
