"""Parts of the association of people: clusters over cameras, existence, outlines of ellipsoids, joints."""

from __future__ import annotations

import numpy as np
import pytest
from tests.plugins.persons.crowded import corner_room

from followspot_persons.associate.assignment.affinity import pair_ratios
from followspot_persons.associate.assignment.contraction import clusters
from followspot_persons.associate.boxes.ellipsoid import boxes_of
from followspot_persons.associate.existence import ExistenceEvidence, missed_detection, visible_shares
from followspot_persons.associate.motion import step
from followspot_persons.associate.multi_view.triangulation import triangulated
from followspot_persons.associate.multi_view.views import Noise, images, views_of
from followspot_persons.associate.tracks.camera_association import clear

VIEWS = views_of(tuple(corner_room().cameras.values()))


def test_a_cluster_never_has_two_detections_of_one_camera() -> None:
    ratio = np.full((4, 4), -np.inf)  # rows 0 and 1 are of one camera, 2 and 3 of two others
    for a, b, value in ((0, 2, 3.0), (1, 2, 2.5), (0, 3, -1.0), (1, 3, 2.0), (2, 3, 1.0)):
        ratio[a, b] = ratio[b, a] = value
    assert [rows.tolist() for rows in clusters(ratio)] == [[0, 2], [1, 3]]


def test_a_weak_tie_is_outweighed_by_the_rest_of_a_cluster() -> None:
    ratio = np.array([[0, 5, -1], [5, 0, 3], [-1, 3, 0]], float)
    assert [rows.tolist() for rows in clusters(ratio)] == [[0, 1, 2]]
    ratio[0, 2] = ratio[2, 0] = -4
    assert [rows.tolist() for rows in clusters(ratio)] == [[0, 1]]


@pytest.mark.parametrize(("size", "body"), [(0.06, False), (0.1, True), (0.7, True), (0.9, False)])
def test_points_that_meet_in_no_body_of_a_persons_size_are_no_pair(size: float, body: bool) -> None:
    around = np.random.default_rng(3).normal(size=(13, 3))
    around -= around.mean(axis=0)
    points = np.array([0.0, 0.0, 1.0]) + size * around / np.sqrt(np.square(around).sum(axis=1).mean())
    xy = np.stack([images(VIEWS.each[camera].projection, points)[0] for camera in (0, 1)])
    ratio = pair_ratios(VIEWS, np.array([0, 1]), xy, Noise(2.0, 0.02, 0.0))
    assert (ratio[0, 1] > 0) == body
    assert np.isneginf(ratio[0, 1]) != body
    assert ratio[0, 1] == ratio[1, 0]
    assert np.isneginf(pair_ratios(VIEWS, np.array([1, 1]), xy, Noise(2.0, 0.02, 0.0))).all()  # of one camera


def test_clear_pairs_lead_over_all_others_of_their_rows_and_columns() -> None:
    ratio = np.array([[9.0, 2.0, -1.0], [6.5, 8.0, 0.0], [-np.inf, 7.0, 3.0], [1.0, 1.0, -2.0]])
    assert np.transpose(clear(ratio, 2.0)).tolist() == [[0, 0]]
    assert np.transpose(clear(ratio[:2], 1.0)).tolist() == [[0, 0], [1, 1]]
    assert np.transpose(clear(ratio[2:, 2:], 3.0)).tolist() == [[0, 0]]
    assert clear(ratio[:0], 1.0)[0].size == clear(ratio[:, :0], 1.0)[0].size == 0


def test_one_camera_alone_is_no_evidence_of_existence() -> None:
    evidence = ExistenceEvidence(np.array([3.0, 6.0]), np.array([-2.0, -2.0]), np.array([1, 2]))
    assert evidence.change().tolist() == [-2.0, 4.0]
    np.testing.assert_allclose(missed_detection(np.array([0.0, 1.0]), 0.9), [0.0, np.log(0.1)])


def test_nearer_bodies_and_the_border_hide() -> None:
    view = VIEWS.each[0]
    box = np.array([[600, 300, 700, 600], [600, 300, 700, 600], [-200, 300, -100, 600]], float)
    depth, real = np.array([3.0, 5.0, 3.0]), np.ones(3, bool)
    assert visible_shares(box, depth, real, view).tolist() == [1.0, 0.0, 0.0]
    assert visible_shares(box, depth, ~real, view).tolist() == [1.0, 1.0, 0.0]  # they may not exist


@pytest.mark.parametrize("long", [0.3, 0.85])
def test_the_box_of_an_ellipsoid_touches_the_images_of_its_surface(long: float) -> None:
    """0.3 m across; along a direction of 25 degrees it may be longer."""
    turn, half = np.radians(25), np.array([long, 0.3, 0.6])
    elongation = np.log(long / 0.3) / 2 * np.array([np.cos(2 * turn), np.sin(2 * turn)])
    state = np.array([0.4, -0.3, 0.9, 0, 0, 0, np.log(long * 0.3) / 2, np.log(0.6), *elongation])
    rng = np.random.default_rng(1)
    points = rng.normal(size=(100_000, 3))
    points *= half / np.linalg.norm(points, axis=1, keepdims=True)
    along = np.array([[np.cos(turn), np.sin(turn), 0], [-np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    there, _ = images(VIEWS.each[1].projection, points @ along + state[:3])
    box, _ = boxes_of(VIEWS.each[1], state[None])
    np.testing.assert_allclose(box[0], [*there.min(axis=0), *there.max(axis=0)], atol=0.5)


def test_two_steps_of_motion_are_one_step_of_their_sum() -> None:
    sigma, memory = np.array(1.2), np.array(0.7)
    a, b, both = (step(seconds, sigma, memory) for seconds in (0.1, 0.25, 0.35))
    assert both.fade == pytest.approx(a.fade * b.fade)
    assert both.reach == pytest.approx(a.reach + a.fade * b.reach)
    place = a.position + 2 * b.reach * a.cross + b.reach**2 * a.velocity + b.position
    assert both.position == pytest.approx(place)
    assert both.cross == pytest.approx(b.fade * (a.cross + b.reach * a.velocity) + b.cross)
    assert both.velocity == pytest.approx(b.fade**2 * a.velocity + b.velocity)


def test_joints_are_where_views_agree_as_exactly_as_their_covariance_says() -> None:
    rng = np.random.default_rng(2)
    noise = Noise(2.0, 0.0, 0.0)
    xyz = rng.uniform([-1, -1, 0.2], [1, 1, 1.8], (400, 3))
    xy = np.array([images(view.projection, xyz)[0] for view in VIEWS.each])
    xy += rng.normal(0, 2.0, xy.shape)
    found = triangulated(VIEWS, np.arange(4), xy, noise)
    error = found.xyz - xyz
    squared = np.vecdot(error, np.linalg.solve(found.covariance, error[..., None])[..., 0])
    assert squared.mean() == pytest.approx(3.0, abs=0.4)  # degrees of freedom
    xy[0, 0] += 200.0  # one view is wrong
    xy[1:, 1] = np.nan  # one view alone
    found = triangulated(VIEWS, np.arange(4), xy, noise)
    assert np.linalg.norm(found.xyz[0] - xyz[0]) < 0.08
    assert (found.views[1], bool(np.isnan(found.xyz[1]).all())) == (0, True)
