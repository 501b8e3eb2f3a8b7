"""`calibrate planes`: plane equations from points that several cameras see."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.datasets import dataset, needs_data
from tests.tools.calibrate.rooms import made_room

from followspot import Room
from followspot.cli.main import main
from followspot.errors import FollowspotError, InputError
from followspot.geometry import project
from followspot.messages import Array
from followspot.room import StageUse
from followspot.room_file import load, save
from followspot_calibrate.planes.dots import dots
from followspot_calibrate.planes.fit import fit_plane, robust_plane, total_least_squares
from followspot_calibrate.planes.frame import moved_plane, onto_floor
from followspot_calibrate.planes.marks import read_marks, sightings
from followspot_calibrate.sightings import Sightings

GLOWBALLS = dataset("glowballs-dev")
needs_recordings = needs_data("glowballs-dev")
CAMERAS = made_room(4, 1).cameras

normals = st.tuples(*[st.floats(-1, 1)] * 3).map(np.array).filter(lambda n: np.linalg.norm(n) > 0.2)


def on_floor(rows: int = 40, height: float = 0.0, seed: int = 0) -> Array:
    """Points of the plane z = height + x / 10."""
    points = np.random.default_rng(seed).uniform([-1, -1, 0], [1, 1, 0], (rows, 3))
    points[:, 2] = height + points[:, 0] / 10
    return points


def marks(points: Array) -> Sightings:
    seen = np.stack([project(camera, points) for camera in CAMERAS], axis=1)
    return sightings(CAMERAS, [dict(enumerate(row.tolist())) for row in seen])


def lines(points: Array, plane: str = "floor", noise: float = 0.0) -> str:
    """What the cameras see of points, as `calibrate planes` reads it; cameras by number and by name."""
    random = np.random.default_rng(1)
    rows = ["plane,point,camera,u,v"]
    for number, camera in enumerate(CAMERAS):
        name = camera.name if number % 2 else number
        for point, (u, v) in enumerate(
            project(camera, points) + random.normal(0, 1, (len(points), 2)) * noise
        ):
            rows.append(f"{plane},{point},{name},{u:.4f},{v:.4f}")
    return "\n".join(rows) + "\n"


@pytest.fixture
def studio(tmp_path: Path) -> Path:
    room = Room("studio", {c.name: c for c in CAMERAS}, {"wall": np.array([1.0, 0.0, 0.0, 2.0])})
    save(room, tmp_path / "room.yaml")
    (tmp_path / "points.csv").write_text(lines(on_floor(height=0.3), noise=0.2))
    return tmp_path


def planes(studio: Path, *more: str) -> int:
    room, points = str(studio / "room.yaml"), str(studio / "points.csv")
    return main(["calibrate", "planes", "--room", room, "--points", points, *more])


@settings(max_examples=50, deadline=None)
@given(normals, st.floats(-3, 3), st.integers(0, 100))
def test_points_of_a_plane_give_the_plane(normal: Array, offset: float, seed: int) -> None:
    normal = normal / np.linalg.norm(normal)
    points = np.random.default_rng(seed).uniform(-2, 2, (30, 3))
    points -= (points @ normal + offset)[:, None] * normal
    plane = total_least_squares(points)
    np.testing.assert_allclose(plane * np.sign(plane[:3] @ normal), [*normal, offset], atol=1e-9)


def test_a_third_of_the_points_elsewhere_does_not_move_the_plane() -> None:
    random = np.random.default_rng(3)
    points = on_floor(60) + random.normal(0, 0.003, (60, 3))
    points[:20, 2] += random.uniform(0.1, 1.0, 20)
    plane, on = robust_plane(points)
    assert not on[:20].any()
    assert on[20:].mean() > 0.9
    truth = np.array([-0.1, 0.0, 1.0]) / np.hypot(0.1, 1)
    assert np.degrees(np.arccos(abs(plane[:3] @ truth))) < 0.2


def test_the_normal_points_towards_the_cameras() -> None:
    for turn in (1.0, -1.0):
        points = on_floor() * [1, turn, 1]
        assert fit_plane("floor", CAMERAS, marks(points)).plane[2] > 0.9


def test_points_in_a_line_and_too_few_points_are_told() -> None:
    line = on_floor() * [1, 0.02, 1]
    assert "nearly on a line" in fit_plane("wall", CAMERAS, marks(line)).warnings[0]
    with pytest.raises(FollowspotError, match=r"plane wall: 5 of 5 points .* 6 needed"):
        fit_plane("wall", CAMERAS, marks(on_floor(5)))


@pytest.mark.parametrize(
    ("elsewhere", "told"),
    [
        (0, []),
        (14, []),
        (18, ["only 22 of 40 points of floor lie on"]),
        (20, ["the points of floor are"]),
    ],
)
def test_points_of_several_planes_are_in_doubt(elsewhere: int, told: list[str]) -> None:
    points = on_floor(40)
    points[:elsewhere, 2] += 0.4
    warnings = fit_plane("floor", CAMERAS, marks(points)).warnings
    assert [text[: len(start)] for text, start in zip(warnings, told, strict=True)] == told


@settings(max_examples=50, deadline=None)
@given(normals, st.floats(-3, 3))
def test_a_floor_becomes_z_0_and_the_cameras_see_the_same(normal: Array, offset: float) -> None:
    plane = np.append(normal / np.linalg.norm(normal), offset)
    motion = onto_floor(plane)
    np.testing.assert_allclose(moved_plane(plane, motion), [0, 0, 1, 0], atol=1e-12)
    assert np.linalg.det(motion.rotation) == pytest.approx(1)
    points = on_floor()
    for camera in CAMERAS:
        seen = project(motion.camera(camera), motion.points(points))
        np.testing.assert_allclose(seen, project(camera, points), atol=1e-7)


def test_planes_are_written_beside_the_planes_that_were_there(studio: Path) -> None:
    assert planes(studio) == 0
    found = load(studio / "room.yaml").planes
    assert list(found) == ["wall", "floor"]
    np.testing.assert_array_equal(found["wall"], [1, 0, 0, 2])
    np.testing.assert_allclose(found["floor"], np.array([-0.1, 0, 1, -0.3]) / np.hypot(0.1, 1), atol=0.003)
    assert "floor" in (studio / "room.planes.html").read_text()


def test_the_floor_takes_cameras_and_all_planes_along(
    studio: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = load(studio / "room.yaml")
    save(replace(before, truth=StageUse("sim.truth", {}, str(studio))), studio / "room.yaml")
    assert planes(studio, "--floor", "floor", "--report", str(studio / "page.html"), "--json") == 0
    after = load(studio / "room.yaml")
    said = capsys.readouterr()
    assert "truth is still given in the old frame" in said.err
    np.testing.assert_allclose(json.loads(said.out)["planes"]["floor"]["plane"], [0, 0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(after.planes["floor"], [0, 0, 1, 0], atol=1e-12)
    apart = after.planes["wall"][:3] @ after.planes["floor"][:3]
    assert apart == pytest.approx(-0.1 / np.hypot(0.1, 1), abs=0.002)
    assert after.cameras["cam0"].center[2] > 1.5
    assert (studio / "page.html").exists()


def test_mistakes_in_the_points_are_named_with_their_line(
    studio: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = lines(on_floor())
    for text, said in [
        ("plane,point,u,v\n", "missing columns: camera"),
        ("plane,point,camera,u,v\n", "has no points"),
        (good + "floor,0,cam9,1,1\n", "needs a camera of the room or its number"),
        (good + "floor,0,cam1,1,1\n", "needs each camera once per point"),
        (good + "floor,0,0,nan,1\n", "needs each camera once per point"),
        (good + "floor,99,0,nan,1\n", "needs a finite number"),
        (good + "../up,99,0,1,1\n", "needs a name of letters"),
    ]:
        (studio / "points.csv").write_text(text)
        with pytest.raises(InputError, match=said):
            read_marks(studio / "points.csv", CAMERAS)
        assert planes(studio) == 2
    (studio / "points.csv").write_text(good)
    before = (studio / "room.yaml").read_bytes()
    assert planes(studio, "--floor", "flor") == 2
    assert 'did you mean "floor"' in capsys.readouterr().err
    assert (studio / "room.yaml").read_bytes() == before


def test_dots_are_found_below_a_pixel_and_unclear_pictures_are_left_out() -> None:
    y, x = np.mgrid[:120, :160]

    def spot(u: float, v: float, height: float = 150.0) -> Array:
        return height * np.exp(-((x - u) ** 2 + (y - v) ** 2) / 5)

    lamp = spot(20, 20, 200)
    places = [(50.3, 60.7), (80.5, 30.2), (110.9, 90.1), (33.3, 100.8)]
    pictures = [lamp + spot(u, v) for u, v in places] + [lamp, lamp + spot(60, 60) + spot(90, 90)]
    found = dots([np.clip(picture, 0, 255).astype("u1") for picture in pictures])
    for place, truth in zip(found, places, strict=False):
        assert place is not None
        assert np.linalg.norm(place - truth) < 0.05
    assert found[4:] == [None, None]


def test_planes_from_clips_of_dots(studio: Path) -> None:
    points = on_floor(12)
    for camera in CAMERAS:
        folder = studio / "clips/floor" / camera.name
        folder.mkdir(parents=True)
        for number, (u, v) in enumerate(project(camera, points)):
            picture = np.zeros((camera.size[1], camera.size[0], 3), "u1")
            cv2.circle(picture, (round(u * 16), round(v * 16)), 64, (255, 255, 255), -1, cv2.LINE_AA, 4)
            cv2.imwrite(str(folder / f"{number:03d}.png"), picture)
    room, clips = str(studio / "room.yaml"), str(studio / "clips")
    assert main(["calibrate", "planes", "--room", room, "--clips", clips]) == 0
    plane = load(room).planes["floor"]
    np.testing.assert_allclose(plane, np.array([-0.1, 0, 1, 0]) / np.hypot(0.1, 1), atol=0.003)
    (studio / "clips/wall").mkdir()
    assert main(["calibrate", "planes", "--room", room, "--clips", clips]) == 2


@needs_recordings
def test_glowballs_planes_are_within_3_mm_and_a_fifth_of_a_degree(tmp_path: Path) -> None:
    room = str(tmp_path / "room.yaml")
    calibration, videos = str(GLOWBALLS / "calibration.json"), str(GLOWBALLS / "dev1")
    assert main(["room", "import", calibration, "--videos", videos, "-o", room]) == 0
    truth = load(room).planes
    points = GLOWBALLS / "planes/plane_points.csv"
    assert main(["calibrate", "planes", "--room", room, "--points", str(points)]) == 0
    cameras = list(load(room).cameras.values())
    for name, seen in read_marks(points, cameras).items():
        fit = fit_plane(name, cameras, seen)
        np.testing.assert_array_equal(load(room).planes[name], fit.plane)
        assert np.degrees(np.arccos(fit.plane[:3] @ truth[name][:3])) < 0.2
        foot = fit.found.points[fit.kept] - fit.distance[fit.kept, None] * fit.plane[:3]
        assert np.abs(foot @ truth[name][:3] + truth[name][3]).max() < 0.003
