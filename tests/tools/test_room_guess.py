"""A rough camera from the sizes of people."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from followspot import InputError, room_file
from followspot.cli.main import main
from followspot.geometry import project
from followspot_room.guessing import Guess, guess_pose, room_of, without_still

SIZE, FOCAL = (768, 576), 900.0


def people(
    pitch: float, height: float, statures: np.ndarray, seed: int = 1, distances: tuple[float, float] = (9, 40)
) -> np.ndarray:
    """Feet and heights in the picture, (N, 3) px, of people scattered before a camera."""
    room = room_of(Path("a.avi"), Path("a.yaml"), SIZE, FOCAL, Guess(pitch, height, 0.0, 0))
    rng = np.random.default_rng(seed)
    xy = np.column_stack([rng.uniform(*distances, len(statures)), rng.uniform(-5, 5, len(statures))])
    feet, head = (project(room.cameras["camera"], np.column_stack([xy, z])) for z in (0 * statures, statures))
    return np.column_stack([feet, feet[:, 1] - head[:, 1]])


@pytest.mark.parametrize(("pitch", "height"), [(10.0, 3.0), (20.0, 7.0), (35.0, 5.5)])
def test_people_of_one_height_tell_where_the_camera_is(pitch: float, height: float) -> None:
    found = guess_pose(people(np.radians(pitch), height, np.full(40, 1.72)), SIZE, FOCAL, 1.72)
    assert np.degrees(found.pitch) == pytest.approx(pitch, abs=0.6)
    assert found.height == pytest.approx(height, rel=0.03)


def test_tall_and_short_people_and_a_few_wrong_detections_do_little_harm() -> None:
    rng = np.random.default_rng(3)
    seen = people(np.radians(20), 7.0, rng.normal(1.72, 0.09, 100))
    seen[:10, 2] *= rng.uniform(0.5, 3.0, 10)
    found = guess_pose(seen, SIZE, FOCAL, 1.72)
    assert np.degrees(found.pitch) == pytest.approx(20, abs=4)
    assert found.height == pytest.approx(7.0, rel=0.15)


def test_what_is_found_again_and_again_at_one_place_is_no_walker() -> None:
    walkers = np.array([[100.0, 200.0, 80.0], [400.0, 300.0, 95.0]])
    lamp = np.array([[250.0, 105.0, 70.0], [251.0, 106.0, 69.0], [250.0, 104.0, 70.0]])
    assert np.array_equal(without_still(np.concatenate([walkers, lamp])), walkers)


def test_people_at_one_distance_are_refused_with_the_remedy() -> None:
    rng = np.random.default_rng(5)
    seen = people(np.radians(10), 3.0, rng.normal(1.72, 0.05, 30), distances=(9.8, 10.2))
    with pytest.raises(InputError, match="fits these people as well as one at") as refused:
        guess_pose(seen, SIZE, FOCAL, 1.72)
    assert "walk near the camera and far from it" in str(refused.value)


def test_people_whom_no_camera_could_see_so_are_refused() -> None:
    above = np.column_stack([np.arange(30) * 25.0, np.full(30, 20.0), np.full(30, 10.0)])
    with pytest.raises(InputError, match="no camera above a floor"):
        guess_pose(above, SIZE, 10.0, 1.72)


def test_too_few_people_are_refused_with_the_remedy() -> None:
    with pytest.raises(InputError, match="only 3 people"):
        guess_pose(people(0.3, 5.0, np.full(3, 1.7)), SIZE, FOCAL, 1.72)


def test_the_room_looks_along_x_from_above_its_origin(tmp_path: Path) -> None:
    room = room_of(tmp_path / "take/a.avi", tmp_path / "a.yaml", SIZE, FOCAL, Guess(0.3, 4.0, 0.1, 20))
    room_file.save(room, tmp_path / "a.yaml")
    camera = room_file.load(tmp_path / "a.yaml").cameras["camera"]
    assert np.allclose(camera.center, [0, 0, 4])
    below = project(camera, np.array([[4.0 / np.tan(0.3), 0.0, 0.0]]))[0]
    assert np.allclose(below, [383.5, 287.5])
    assert camera.source is not None
    assert camera.source.params["path"] == "take/a.avi"


def test_a_video_without_people_and_a_field_out_of_range_end_with_code_2(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    writer = cv2.VideoWriter(str(tmp_path / "a.avi"), cv2.VideoWriter.fourcc(*"MJPG"), 30, (64, 48))
    writer.write(np.zeros((48, 64, 3), np.uint8))
    writer.release()
    command = ["room", "guess", str(tmp_path / "a.avi"), "-o", str(tmp_path / "a.yaml")]
    assert main(command) == 2
    assert "only 0 people" in capsys.readouterr().err
    assert main([*command, "--field", "300"]) == 2
    assert "out of range" in capsys.readouterr().err
    assert not (tmp_path / "a.yaml").exists()
