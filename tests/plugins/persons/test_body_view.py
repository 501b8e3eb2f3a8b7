"""Features of posed bodies stand where the camera's own model puts them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from tests.plugins.persons.drawn import perspective, standing

from followspot.geometry import project
from followspot_persons.body.shape import read_shape
from followspot_persons.body.view import view
from followspot_persons.likelihood.fitness import UNSEEN_EDGE, Fitness, Picture, Weights

SHAPE = read_shape()


def placed(pose):
    """Torso features of a body in the room, (F, 3) m: forward, left and up from the foot of its axis."""
    forward, left, up = (SHAPE.surface.position * pose[2]).T
    sine, cosine = np.sin(pose[3]), np.cos(pose[3])
    return np.column_stack(
        [pose[0] + forward * cosine - left * sine, pose[1] + forward * sine + left * cosine, up]
    )


@pytest.mark.parametrize("heading", [0.0, 1.1, np.pi, -2.0])
@pytest.mark.parametrize(("x", "y"), [(2.0, 0.0), (2.5, 0.6), (4.0, -1.2)])
def test_surface_features_lie_where_the_camera_sees_them(x, y, heading):
    """To first order of the body's depth: within a fiftieth of the upper body's height."""
    camera, pose = perspective(), standing(x, y, heading=heading)
    seen = view(camera, SHAPE, pose[None])
    height = seen.box[0, 3] - seen.box[0, 1]
    apart = np.hypot(*(seen.surface[0] - project(camera, placed(pose))).T)
    assert apart.max() < height / 25
    assert np.median(apart) < height / 100


def test_a_taller_or_nearer_body_is_larger_and_one_to_the_left_is_left_in_the_picture():
    camera = perspective()
    usual, tall, near, left = view(
        camera, SHAPE, np.stack([standing(3), standing(3, height=1.9), standing(2), standing(3, 0.5)])
    ).box
    assert tall[1] < usual[1]
    assert near[3] - near[1] > 1.4 * (usual[3] - usual[1])
    assert left[0] < usual[0] - 20


@pytest.mark.filterwarnings("error")
def test_a_body_without_an_image_has_no_places_and_no_likelihood_and_warns_of_nothing():
    camera = perspective()
    behind, before = standing(-3), standing(3)
    seen = view(camera, SHAPE, np.stack([behind, before]))
    assert np.isnan(seen.edge[0]).all()
    assert np.isfinite(seen.normal).all()
    pixels = np.zeros((camera.size[1] * camera.size[0],), np.uint8)
    everywhere = Picture(camera, pixels + 255, pixels, np.tile(pixels[:, None], 3))
    likelihood = Fitness(everywhere, SHAPE, Weights()).edge(seen)
    assert likelihood[0] == 0
    assert likelihood[1] > 0


@pytest.mark.parametrize("roll", [0.3, -0.5])
def test_edges_lean_with_the_body_in_the_picture_of_a_camera_that_is_tilted_sideways(roll):
    upright, pose = perspective(), standing(3)
    sine, cosine = np.sin(roll), np.cos(roll)
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    tilted = replace(upright, rotation=turn @ upright.rotation, translation=turn @ upright.translation)
    before, after = (view(camera, SHAPE, pose[None]).normal[0] for camera in (upright, tilted))
    assert after - before == pytest.approx(np.full(len(before), roll), abs=0.02)


def test_edges_that_a_nearer_person_hides_speak_neither_for_nor_against_a_body():
    camera = perspective()
    seen = view(camera, SHAPE, standing(3)[None])
    nothing = np.zeros(camera.size[0] * camera.size[1], np.uint8)
    colors = np.tile(nothing[:, None], 3)

    def edge(magnitude, hidden):
        picture = Picture(camera, nothing + np.uint8(magnitude), nothing, colors, hidden)
        return Fitness(picture, SHAPE, Weights()).edge(seen)[0]

    assert edge(0, nothing) == 0
    assert edge(0, nothing + 1) == edge(255, nothing + 1) == pytest.approx(UNSEEN_EDGE)
    half = nothing.copy()
    half.reshape(camera.size[::-1])[:, : camera.size[0] // 2] = 1
    assert 0 < edge(0, half) < UNSEEN_EDGE
