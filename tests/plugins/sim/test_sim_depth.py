"""What the simulated depth cameras measure."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from followspot import Context, room_file
from followspot.geometry import depth_rays, project
from followspot.testing import check_stage, tiny_room
from followspot_sim.depth_camera import SimDepthCamera
from followspot_sim.rendering.ray_casting import first_hit
from followspot_sim.visibility import visible_fraction

SIMULATED = room_file.load(Path(__file__).parents[3] / "graphs/rooms/simulated.yaml")
CAMERAS = {name: replace(camera, kind="depth") for name, camera in SIMULATED.cameras.items()}
ROOM = replace(SIMULATED, cameras=CAMERAS)
PERFECT = {"depth_sigma": 0, "depth_sigma_growth": 0, "hole_share": 0, "edge_hole_share": 0}


def camera(name: str, **params: object) -> SimDepthCamera:
    stage = SimDepthCamera(Context.serving(CAMERAS[name], ROOM), seed=7, frames=3, **params)
    stage.setup()
    return stage


def test_each_depth_leads_to_the_surface_that_the_pixel_shows():
    stage = camera("cam0")
    points = CAMERAS["cam0"].center + stage._picture.exact(90)[..., None] * depth_rays(CAMERAS["cam0"])
    scene = stage._picture.world.scene(90)
    surface = np.abs(
        points @ np.array(list(ROOM.planes.values()))[:, :3].T + [p[3] for p in ROOM.planes.values()]
    )
    ends = np.concatenate([scene.limbs, np.repeat(scene.balls[:, None], 2, axis=1)])
    radii = np.concatenate([scene.radius, [t.radius for t in ROOM.targets.values()]])
    axis = ends[:, 1] - ends[:, 0]
    along = np.einsum("hwkc,kc->hwk", points[:, :, None] - ends[:, 0], axis)
    along = np.clip(along / np.maximum((axis * axis).sum(axis=1), 1e-12), 0, 1)
    foot = ends[:, 0] + along[..., None] * axis
    capsule = np.abs(np.linalg.norm(points[:, :, None] - foot, axis=3) - radii)
    assert np.minimum(surface.min(axis=2), capsule.min(axis=2)).max() < 1e-5
    assert (capsule.min(axis=2) < 1e-5).sum() > 1000


def test_a_ball_in_view_is_measured_a_radius_before_its_centre():
    checked = 0
    for name in CAMERAS:
        stage = camera(name)
        for frame in (0, 200, 500):
            scene = stage._picture.world.scene(frame)
            radii = np.array([t.radius for t in ROOM.targets.values()])
            seen = visible_fraction([CAMERAS[name]], scene, radii)[0] == 1
            depth = stage._picture.exact(frame)
            for ball, radius in zip(scene.balls[seen], radii[seen], strict=True):
                u, v = np.rint(project(CAMERAS[name], ball[None])[0]).astype(int)
                front = CAMERAS[name].center + depth[v, u] * depth_rays(CAMERAS[name])[v, u]
                assert abs(np.linalg.norm(front - ball) - radius) < 1e-6
                checked += 1
    assert checked > 10


def test_rays_meet_a_capsule_on_its_surface_and_not_inside():
    rng = np.random.default_rng(3)
    ends, radius, origin = np.array([[0.1, 0.0, 3.0], [0.5, 0.3, 3.4]]), 0.2, np.zeros(3)
    rays = rng.normal([0.1, 0.05, 1.0], [0.15, 0.15, 0], (400, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    steps = np.linspace(0, 6, 6001)
    axis = ends[1] - ends[0]
    points = rays[:, None] * steps[:, None]
    along = np.clip((points - ends[0]) @ axis / (axis @ axis), 0, 1)
    inside = np.linalg.norm(points - ends[0] - along[..., None] * axis, axis=2) < radius
    first = np.where(inside.any(axis=1), steps[inside.argmax(axis=1)], np.inf)
    found = first_hit(origin, rays, ends, radius)
    assert (np.isfinite(found) != np.isfinite(first)).sum() < 3  # rays that barely touch it
    both = np.isfinite(found) & np.isfinite(first)
    assert both.sum() > 50
    assert np.abs(found[both] - first[both]).max() < 0.02


def test_noise_grows_with_depth_and_holes_have_their_share():
    params = {"hole_share": 0.02, "depth_sigma": 0.001, "depth_sigma_growth": 0.001}
    stage = camera("cam0", people=0, **params)
    exact = stage._picture.exact(0)
    shots = np.array([shot.depth for shot in stage.process()])
    empty = shots[0] == 0
    assert 0.015 < empty[exact < 8].mean() < 0.035
    assert empty[exact > 8].all()
    for near, far in ((4.0, 4.5), (6.0, 7.0)):
        here = (exact > near) & (exact < far) & ~empty
        wanted = 0.001 + 0.001 * exact[here] ** 2
        assert 0.9 < ((shots[0][here] - exact[here]) / wanted).std() < 1.1
    assert not np.array_equal(shots[0], shots[1])


def test_the_same_seed_gives_the_same_depths_and_another_camera_others():
    one, again, other = (next(camera(name).process()).depth for name in ("cam0", "cam0", "cam3"))
    assert one.tobytes() == again.tobytes()
    assert one.tobytes() != other.tobytes()


def test_it_keeps_the_promises_of_stages():
    check_stage(SimDepthCamera, room=tiny_room("depth", "depth"), frames=5)
