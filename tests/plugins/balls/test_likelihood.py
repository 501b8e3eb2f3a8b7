"""A ball's likelihood ratio: which blobs speak for a ball, which for paint, light, reflectors or chance."""

from __future__ import annotations

import numpy as np
import pytest

from followspot.messages import Array
from followspot_balls.association.likelihood import (
    MINIMUM_CLUTTER_RATIO,
    BallModel,
    BlobResiduals,
    LikeliestBlobs,
    ball_densities,
    ball_log_ratio,
    ball_vs_reflector_log_ratio,
    clutter_density,
    information,
    likeliest_blobs,
    log_occam_factors,
    precision,
    view_log_ratios,
)

MODEL = BallModel(0.6, 0.015, 3.0, 0.8, 0.12, 0.6)
COLOR = np.array([True, True, False, False])
NO_OCCAM = np.zeros((3, 1))


def seen(
    distances: list[float], shares: list[float], radius: float = 4.0, clutter: float = 1.0
) -> BlobResiduals:
    """Blobs of one view at distances (px) from the image of one place. clutter: share of the usual."""
    count = len(distances)
    return BlobResiduals(
        np.square(distances).reshape(1, 1, count),
        np.array(shares).reshape(1, 1, count),
        np.full((1, 1), radius),
        np.ones((1, 1, count), bool),
        np.ones((1, 1), bool),
        np.full((1, count), clutter),
    )


def ratio(views: list[float], other: float = 1.0, color: Array = COLOR) -> float:
    return float(ball_log_ratio(np.array([views]), color, NO_OCCAM, other)[0])


def test_a_density_is_one_over_all_places_of_the_blob() -> None:
    across = np.linspace(-20, 20, 401)
    x, y = np.meshgrid(across, across)
    residuals = seen(np.hypot(x, y).ravel().tolist(), [0.5] * x.size)
    assert ball_densities(MODEL, residuals)[0].sum() * 0.1**2 == pytest.approx(1.0, rel=1e-3)  # 2 * share


def test_a_fragment_says_less_than_a_whole_ball_and_may_be_farther_off() -> None:
    (whole, small), (near, far) = ball_densities(MODEL, seen([0, 0], [1.0, 0.2]))[0][0, 0], (0, 3)
    assert small < 0.2 * whole
    whole_far, small_far = ball_densities(MODEL, seen([far, far], [1.0, 0.2]))[0][0, 0]
    assert small_far / small > 10 * whole_far / whole
    assert near == 0


def test_merged_light_and_a_vague_place_widen_the_density() -> None:
    alone, merged = ball_densities(MODEL, seen([0, 0], [1.0, 1.8]))[1][0, 0]
    assert merged > alone + 2.0
    assert ball_densities(MODEL, seen([0], [1.0]), 3.0)[1][0, 0, 0] == pytest.approx(alone + 3.0)


def test_what_cannot_be_the_target_has_no_density() -> None:
    residuals = seen([0], [1.0])._replace(compatible=np.zeros((1, 1, 1), bool))
    assert ball_densities(MODEL, residuals)[0] == 0


def test_clutter_around_balls_below_a_radius_is_no_denser() -> None:
    limited = MODEL._replace(minimum_radius=np.array([3.0]))
    for radius, counts in ((1.0, 3.0), (3.0, 3.0), (4.0, 4.0)):
        density = clutter_density(limited, seen([0], [1.0], radius=radius))
        assert density == pytest.approx(MODEL.clutter / counts**2)


def test_other_blobs_nearby_count_as_clutter_and_far_ones_do_not() -> None:
    least = MODEL.clutter / 4.0**2
    assert clutter_density(MODEL, seen([0], [1.0])) == pytest.approx(least)
    assert clutter_density(MODEL, seen([0, 12.1], [1.0, 1.0])) == pytest.approx(least)
    three = clutter_density(MODEL, seen([0, 5, 6, 7], [1.0, 0.2, 0.2, 0.2]))
    assert three == pytest.approx(np.full((1, 1, 4), 3 / (np.pi * 12**2)))


def test_a_blob_where_there_is_less_clutter_than_usual_is_stronger_evidence() -> None:
    usual = seen([0], [1.0])
    little = seen([0], [1.0], clutter=0.1)
    assert clutter_density(MODEL, little) == pytest.approx(0.1 * clutter_density(MODEL, usual))
    ratios = [likeliest_blobs(MODEL, residuals, np.zeros((1, 1, 1))).ratio for residuals in (usual, little)]
    assert ratios[1] == pytest.approx(10 * ratios[0])


@pytest.mark.parametrize(
    ("clutter", "share"),
    [(0.0, MINIMUM_CLUTTER_RATIO), (-1.0, MINIMUM_CLUTTER_RATIO), (np.nan, 1.0), (np.inf, 1.0), (5.0, 1.0)],
)
def test_clutter_that_another_stage_tells_is_no_less_than_the_minimum_and_no_more_than_usual(
    clutter: float, share: float
) -> None:
    usual = clutter_density(MODEL, seen([0], [1.0]))
    assert clutter_density(MODEL, seen([0], [1.0], clutter=clutter)) == pytest.approx(share * usual)


def test_a_blob_that_is_another_target_is_no_evidence() -> None:
    residuals, nobody = seen([0], [1.0]), np.zeros((1, 1, 1))
    alone = view_log_ratios(0.6, likeliest_blobs(MODEL, residuals, nobody), residuals.in_picture)
    theirs = view_log_ratios(0.6, likeliest_blobs(MODEL, residuals, nobody + 0.5), residuals.in_picture)
    assert alone > 3
    assert theirs < 0


def test_the_likeliest_blob_is_the_nearest_of_equal_ones() -> None:
    likely = likeliest_blobs(MODEL, seen([2, 0.5, 3], [1.0, 1.0, 1.0]), np.zeros((1, 1, 3)))
    assert likely.slot == 1


def test_a_view_without_the_blob_speaks_against_the_place_unless_it_cannot_see_it() -> None:
    residuals = seen([30], [1.0])
    likely = likeliest_blobs(MODEL, residuals, np.zeros((1, 1, 1)))
    assert view_log_ratios(0.6, likely, residuals.in_picture)[0, 0] == pytest.approx(np.log(0.4), abs=1e-6)
    assert view_log_ratios(0.6, likely, np.zeros((1, 1), bool))[0, 0] == 0


def test_only_both_kinds_of_cameras_tell_a_ball() -> None:
    assert ratio([5, 5, 5, 5]) > 9
    assert ratio([9, 9, -1, -1]) < -1.9, "paint or light"
    assert ratio([-1, -1, 9, 9]) < -1.9, "a reflector"
    assert ratio([9, 9, -1, -1], other=0.1) == pytest.approx(ratio([9, 9, -1, -1]) + np.log(10), abs=1e-3)


@pytest.mark.parametrize("kind", [True, False])
def test_with_one_kind_of_camera_all_views_add_up(kind: bool) -> None:
    assert ratio([2, 3, -1, 4], color=np.full(4, kind)) == pytest.approx(8)


def test_the_less_a_view_showed_the_ball_the_less_its_blob_and_its_lack_say() -> None:
    slot, inside = np.zeros((1, 2), int), np.ones((1, 2), bool)
    likely = LikeliestBlobs(slot, np.array([[50.0, 0.0]]), np.ones((1, 2)))
    often, seldom = view_log_ratios(0.9, likely, inside), view_log_ratios(0.1, likely, inside)
    assert often[0] == pytest.approx(np.log([45.1, 0.1]))
    assert seldom[0] == pytest.approx(np.log([5.9, 0.9]))


def test_a_blob_informs_by_its_precision_as_far_as_it_is_the_balls() -> None:
    likely = LikeliestBlobs(np.zeros((1, 3), int), np.ones((1, 3)), np.array([[4.0, 4.0, 4.0]]))
    views = np.log([[5.0, 2.0, 0.5]])
    assert precision(likely, views) == pytest.approx(np.array([[0.8 / 4, 0.5 / 4, 0.0]]))
    jacobian = np.array([[[[40.0, 0, 0], [0, 40.0, 0]]]])
    known = information(jacobian, np.full((1, 1), 0.25))
    assert known[0, 0] == pytest.approx(np.diag([400.0, 400.0, 0.0]))


def test_a_lone_pair_may_be_a_coincidence_the_more_so_the_less_was_known() -> None:
    rays = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [-0.6, 0.8, 0]])
    across = np.linalg.svd(rays[:, None])[2][None, :, 1:]

    def occam(views: list[float], sigma: float) -> Array:
        probability = 1 - np.exp(-np.maximum([views], 0.0))
        known = information(40 * across, probability)
        return log_occam_factors(known, COLOR, np.array([1 / sigma**2]))[:, 0]

    pair = [5, -1, 5, -1]
    assert (occam(pair, 0.15) < 0).all()
    assert (occam(pair, 0.15) < occam(pair, 0.05) - 0.5).all()
    assert occam([5, 5, 5, -1], 0.15)[1] > occam(pair, 0.15)[1] + 0.5, "two colour views fix the place"
    assert occam([-1] * 4, 0.15) == pytest.approx(0)


def test_the_share_of_places_at_which_views_agree_follows_from_what_they_tell() -> None:
    """One colour and one infrared view of one direction each, beside a prior: determinants by hand."""
    known = np.zeros((1, 2, 3, 3))
    known[0, 0, 0, 0], known[0, 1, 1, 1] = 8.0, 24.0
    occam = log_occam_factors(known, np.array([True, False]), np.array([1.0]))
    assert occam[:, 0] == pytest.approx(0.5 * np.log([1 / 225, 9 / 225, 25 / 225]))


def test_paint_and_reflectors_explain_the_views_of_their_kind_by_their_own_chance() -> None:
    """Colour views 18 and infrared views -2 nats: paint at a share exp(-1) of the places is the rival."""
    occam = np.array([[-5.0], [-1.0], [-3.0]])
    assert ball_log_ratio(np.array([[9.0, 9, -1, -1]]), COLOR, occam, 1.0) == pytest.approx(-3.0, abs=1e-3)
    assert ball_log_ratio(np.array([[-1.0, -1, 9, 9]]), COLOR, occam, 1.0) == pytest.approx(-5.0, abs=1e-3)


def test_against_a_reflector_colour_cameras_alone_tell_a_ball_if_there_are_any() -> None:
    views, occam = np.array([[2.0, 1.0, -4.0, -5.0]]), np.array([[-0.5], [-0.25], [-0.125]])
    assert ball_vs_reflector_log_ratio(views, COLOR, occam) == pytest.approx([2.875])
    for color in (np.ones(4, bool), np.zeros(4, bool)):
        assert ball_vs_reflector_log_ratio(views, color, occam) == pytest.approx([-6.5])
