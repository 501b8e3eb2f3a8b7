"""Labelled points of several cameras become places in the room, and those the tracks of targets."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from tests.plugins.vision.made_points import FPS, ROOT, SIMULATED, simulated, write_points

from followspot import Context, Header, Room
from followspot.cli.main import main
from followspot.geometry import project, undistort
from followspot.messages import stamped
from followspot.points import Points2D, Points3D
from followspot.tracking import LOST, TRACKED, Forecast
from followspot_vision.targets import Targets
from followspot_vision.triangulate import Triangulate

ROOM = simulated()


def seen(camera: str, **places: list[list[float]]) -> Points2D:
    """Points of one picture: by label, in px as they were taken."""
    labels = tuple(places)
    pixel = np.array([xy for label in labels for xy in places[label]], "f8").reshape(-1, 2)
    label = [i for i, name in enumerate(labels) for _ in places[name]]
    message = Points2D(
        camera=camera,
        labels=labels,
        label=np.array(label, "i4"),
        instance=np.full(len(label), -1, "i4"),
        pixel=pixel,
        xy=undistort(ROOM.cameras[camera], pixel),
        score=np.ones(len(label)),
    )
    return stamped(message, Header(f"points/{camera}", 0, 0))


def images(xyz: list[list[float]], rng: np.random.Generator | None = None) -> dict[str, list[list[float]]]:
    """Points of each camera, px, with noise of 1 px."""
    noise = np.zeros(2) if rng is None else rng.normal(0, 1, (len(xyz), 2))
    return {name: (project(c, np.array(xyz)) + noise).tolist() for name, c in ROOM.cameras.items()}


def triangulated(*points: Points2D, room: Room = ROOM, **params: float) -> Points3D:
    stage = Triangulate(Context(room=room), **params)
    stage.setup()
    return stage.process(points)


PLACES = [[0.5, -0.3, 1.0], [-0.6, 0.4, 0.5], [0.1, 0.1, 1.5]]


def test_exact_points_give_exact_places_by_label() -> None:
    there = images(PLACES)
    found = triangulated(*(seen(name, red=xy[:1], nose=xy[1:]) for name, xy in there.items()))
    assert [found.labels[i] for i in found.label] == ["red", "nose", "nose"]
    np.testing.assert_allclose(found.xyz[:1], PLACES[:1], atol=1e-6)
    np.testing.assert_allclose(sorted(found.xyz[1:].tolist()), sorted(PLACES[1:]), atol=1e-6)
    assert found.views.tolist() == [6, 6, 6]
    assert found.error.max() < 1e-4


def test_false_points_are_left_out() -> None:
    rng = np.random.default_rng(1)
    there = images(PLACES[:1])
    points = [
        seen(name, red=[*xy, *(rng.random((4, 2)) * ROOM.cameras[name].size).tolist()])
        for name, xy in there.items()
    ]
    best = triangulated(*points, minimum_views=4)
    np.testing.assert_allclose(best.xyz, PLACES[:1], atol=0.05)
    assert best.views[0] >= 6


def test_a_camera_alone_or_a_label_apart_gives_nothing() -> None:
    there = images(PLACES[:1])
    assert len(triangulated(seen("cam0", red=there["cam0"])).xyz) == 0
    assert len(triangulated(seen("cam0", red=there["cam0"]), seen("cam1", blue=there["cam1"])).xyz) == 0
    assert len(triangulated().xyz) == 0


def test_a_camera_that_looks_away_does_not_agree() -> None:
    """A place behind a camera has an image in its equations, but not in its picture."""
    near = ROOM.cameras["cam2"]
    place = near.center - 0.5 * near.rotation[2]
    depth, points = [], []
    for name, camera in ROOM.cameras.items():
        image = camera.projection @ [*place, 1.0]
        depth.append(image[2])
        points.append(seen(name, red=[[0.0, 0.0]]))
        points[-1].__dict__["xy"] = (image[:2] / image[2])[None]
    found = triangulated(*points, maximum_sigma=10.0)
    np.testing.assert_allclose(found.xyz, place[None], atol=1e-6)
    assert found.views.tolist() == [sum(each > 0 for each in depth)]
    assert min(depth) < 0


def test_rays_that_are_nearly_parallel_give_nothing() -> None:
    there = images([[0.0, 0.0, 1.0]])
    pair = seen("cam0", red=there["cam0"]), seen("cam1", red=there["cam1"])
    assert len(triangulated(*pair).xyz) == 1
    assert len(triangulated(*pair, maximum_sigma=0.001).xyz) == 0


def test_the_covariance_is_that_of_the_errors() -> None:
    rng = np.random.default_rng(4)
    errors, expected = [], []
    for _ in range(300):
        place = [0.3, -0.2, 1.1]
        points = [
            seen(name, red=(project(c, np.array([place])) + rng.normal(0, 1, 2)).tolist())
            for name, c in list(ROOM.cameras.items())[:3]
        ]
        found = triangulated(*points, point_sigma=1.0, maximum_error=10.0)
        if len(found.xyz) == 1 and found.views[0] == 3:
            errors.append(found.xyz[0] - place)
            expected.append(found.covariance[0])
    assert len(errors) > 280
    squared = [e @ np.linalg.solve(c, e) for e, c in zip(errors, expected, strict=True)]
    assert np.mean(squared) == pytest.approx(3.0, rel=0.2)  # chi squared of three numbers


def forecast(*places: list[float] | None) -> Forecast:
    count = len(places)
    xyz = np.array([[0.0, 0.0, 0.0] if place is None else place for place in places])
    state = np.array([LOST if place is None else TRACKED for place in places], "u1")
    return Forecast(1 / 30, state, xyz, 0 * xyz, np.zeros((count, 3, 3)), xyz, xyz)


def named(*rows: tuple[str, list[float], int]) -> Points3D:
    labels = tuple(dict.fromkeys(label for label, _, _ in rows))
    count = len(rows)
    return Points3D(
        labels=labels,
        label=np.array([labels.index(label) for label, _, _ in rows], "i4"),
        xyz=np.array([xyz for _, xyz, _ in rows], "f8").reshape(-1, 3),
        covariance=np.broadcast_to(np.eye(3), (count, 3, 3)).copy(),
        views=np.array([views for _, _, views in rows], "i4"),
        error=np.zeros(count),
        score=np.ones(count),
    )


def test_labels_name_targets_and_the_best_point_counts() -> None:
    told: list[str] = []
    stage = Targets(Context(room=ROOM, warn=told.append))
    stage.setup()
    message = named(
        ("blue", [1, 1, 1], 2), ("read", [0, 0, 0], 9), ("blue", [2, 2, 2], 3), ("green", [0, 0, 1], 2)
    )
    alone = stage.process(message)
    assert alone.target.tolist() == [0, 2]  # green, blue
    assert alone.xyz.tolist() == [[0, 0, 1], [2, 2, 2]]
    assert alone.support.tolist() == [2, 3]
    near = stage.process(message, forecast(None, None, [1.1, 1, 1]))
    assert near.xyz.tolist() == [[0, 0, 1], [1, 1, 1]]
    far = stage.process(message, forecast([3, 3, 3], None, [1.1, 1, 1]))
    assert far.target.tolist() == [2]
    assert len(told) == 1
    assert 'label "read"' in told[0]
    assert 'did you mean "red"' in told[0]


@pytest.mark.thorough
def test_points_give_the_same_tracks_in_every_placement(tmp_path: Path) -> None:
    write_points(tmp_path / "points.csv", ROOM, 30)
    words = ["run", str(ROOT / "graphs/points.yaml"), "--room", str(SIMULATED), "--quiet"]
    words += ["--set", f"points.path={tmp_path / 'points.csv'}", "--set", f"points.fps={FPS}"]
    assert main([*words, "--out", str(tmp_path / "one")]) == 0
    for placement in ("camera", "stage"):
        assert main([*words, "--out", str(tmp_path / placement), "--placement", placement]) == 0
        same = (tmp_path / "one/tracks.csv").read_bytes() == (
            tmp_path / placement / "tracks.csv"
        ).read_bytes()
        assert same, placement


def test_points_of_the_simulated_room_become_tracks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """0.7 px of noise, a tenth of the points missing, and a false point of each label in each picture."""
    frames = 120
    write_points(tmp_path / "points.csv", ROOM, frames)
    words = ["--room", str(SIMULATED), "--set", f"points.path={tmp_path / 'points.csv'}"]
    words += ["--set", f"points.fps={FPS}", "--out", str(tmp_path / "a"), "--quiet", "--json"]
    assert main(["run", str(ROOT / "graphs/points.yaml"), *words]) == 0
    found = json.loads(capsys.readouterr().out)["targets"]
    assert found.keys() == {"green", "red", "blue"}
    for each in found.values():
        assert each["coverage"] > 0.97
        assert each["rmse_mm"] < 12
        assert each["identity_switches"] == 0
