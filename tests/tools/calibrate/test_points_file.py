"""Files of points: three formats, and every mistake with its place."""

from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest
from tests.tools.calibrate.rooms import made_room

from followspot.errors import InputError
from followspot_calibrate.points_file import read_points

CSV = "frame,camera,u,v\n0,0,1,2\n0,1,3,4\n7,1,5.5,6\n"


def test_csv_numbers_cameras_and_marks_what_is_not_seen(tmp_path):
    path = written(tmp_path / "points.csv", CSV)
    found = read_points(path, size=(64, 48))
    assert found.cameras == ("cam0", "cam1")
    assert found.frame.tolist() == [0, 7]
    assert found.label.tolist() == [0, 0]
    assert found.seen.tolist() == [[True, True], [False, True]]
    assert found.pixel[1, 1].tolist() == [5.5, 6]
    assert found.sizes.tolist() == [[64, 48], [64, 48]]


def test_csv_takes_names_and_numbers_of_the_room_and_labels_of_the_wand(tmp_path):
    cameras = made_room(cameras=3).cameras
    text = "frame,camera,u,v,point\n0,cam2,1,2,0\n0,2,3,4,1\n"
    found = read_points(written(tmp_path / "points.csv", text), cameras)
    assert found.cameras == ("cam0", "cam1", "cam2")
    assert found.label.tolist() == [0, 1]
    assert found.seen.tolist() == [[False, False, True]] * 2


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("frame,camera,u\n0,0,1\n", "missing columns: v"),
        ("frame,camera,u,v\n", "has no points"),
        ("frame,camera,u,v\n0,0,1,nan\n", "points.csv:2:7"),
        ("frame,camera,u,v\n0.5,0,1,2\n", "whole number"),
        ("frame,camera,u,v\n-1,0,1,2\n", "whole number"),
        ("frame,camera,u,v\n1e300,0,1,2\n", "whole number"),
        ("frame,camera,u,v\n0,a b,1,2\n", "letters, digits"),
        ("frame,camera,u,v\n0,0,1,2\n0,0,1,2\n", "each camera once"),
        ("frame,camera,u,v\n0,0,900,2\n1,0,900,2\n", "most points of cam0 lie outside"),
    ],
)
def test_a_wrong_csv_file_is_told_with_its_line(tmp_path, text, told):
    with pytest.raises(InputError, match=told):
        read_points(written(tmp_path / "points.csv", text), size=(64, 48))


def test_pictures_of_unknown_size_are_asked_for(tmp_path):
    with pytest.raises(InputError, match="--size"):
        read_points(written(tmp_path / "points.csv", CSV))


def test_a_camera_that_the_room_lacks_is_told(tmp_path):
    path = written(tmp_path / "points.csv", "frame,camera,u,v\n0,9,1,2\n")
    with pytest.raises(InputError, match="cam0, "):
        read_points(path, made_room(cameras=3).cameras)


def test_the_toolbox_folder_is_read(tmp_path):
    folder = toolbox(tmp_path)
    found = read_points(folder)
    assert found.pixel[0].tolist() == [[1, 2], [3, 4]]
    assert found.seen.tolist() == [[True, True], [False, True]]
    assert found.sizes.tolist() == [[64, 48], [32, 24]]


@pytest.mark.parametrize(
    ("file", "text", "told"),
    [
        ("points.dat", "1 2\n3 4\n", "three rows"),
        ("points.dat", "1 2\n3 word\n1 1\n", "rows of numbers"),
        ("IdMat.dat", "1 1\n", "2 rows and 2 columns"),
        ("Res.dat", "64 48\n", "width and height of 2 cameras"),
    ],
)
def test_a_wrong_toolbox_file_is_named(tmp_path, file, text, told):
    folder = toolbox(tmp_path)
    written(folder / file, text)
    with pytest.raises(InputError, match=told) as error:
        read_points(folder)
    assert file in str(error.value)


def test_a_toolbox_file_that_is_absent_is_named(tmp_path):
    with pytest.raises(InputError, match=r"points\.dat cannot be read"):
        read_points(tmp_path)


def test_keypoints_below_the_confidence_were_not_seen(tmp_path):
    keypoints = np.ones((2, 3, 1, 3), np.float32)
    keypoints[1, :, 0, 2] = [0.2, 0.6, np.nan]
    views = np.array([[0, 0, 64, 48], [0, 0, 32, 24]])
    np.savez(tmp_path / "points.npz", keypoints=keypoints, views_xywh=views)
    found = read_points(tmp_path / "points.npz", confidence=0.5)
    assert found.seen.tolist() == [[True, False], [True, True], [True, False]]
    assert found.sizes.tolist() == [[64, 48], [32, 24]]


def test_pictures_of_another_size_than_the_rooms_are_told(tmp_path):
    views = np.array([[0, 0, 64, 48]] * 2)
    np.savez(tmp_path / "points.npz", keypoints=np.ones((2, 3, 1, 3), np.float32), views_xywh=views)
    with pytest.raises(InputError, match="cam0 have 64x48 px, in the room"):
        read_points(tmp_path / "points.npz", made_room(cameras=2).cameras)


@pytest.mark.parametrize("size", [0, 65536])
def test_sizes_that_no_picture_has_are_not_taken(tmp_path, size):
    views = np.array([[0, 0, 64, 48], [0, 0, 64, size]])
    np.savez(tmp_path / "points.npz", keypoints=np.ones((2, 3, 1, 3), np.float32), views_xywh=views)
    assert read_points(tmp_path / "points.npz", size=(64, 48)).sizes.tolist() == [[64, 48], [64, 48]]


def test_pickles_wrong_shapes_and_other_files_are_refused(tmp_path):
    np.savez(tmp_path / "pickled.npz", keypoints=np.array([{}], dtype=object))
    np.savez(tmp_path / "flat.npz", keypoints=np.ones((2, 3)))
    np.savez(tmp_path / "other.npz", points=np.ones((2, 3)))
    written(tmp_path / "text.npz", "no zip")
    written(tmp_path / "points.json", "{}")
    for name in ("pickled.npz", "flat.npz", "other.npz", "text.npz", "points.json", "absent.npz"):
        with pytest.raises(InputError, match=name):
            read_points(tmp_path / name, size=(64, 48))


def test_a_file_that_unpacks_to_too_much_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("followspot_calibrate.points_file.keypoints.MOST_BYTES", 1000)
    with zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as archive:
        data = io.BytesIO()
        np.save(data, np.zeros((2, 100, 1, 3), np.float32))
        archive.writestr("keypoints.npy", data.getvalue())
    with pytest.raises(InputError, match="unpacks to"):
        read_points(tmp_path / "bomb.npz", size=(64, 48))


def toolbox(tmp_path):
    folder = tmp_path / "toolbox"
    folder.mkdir()
    written(folder / "points.dat", "1 0\n2 0\n1 1\n3 5\n4 6\n1 1\n")
    written(folder / "IdMat.dat", "1 0\n1 1\n")
    written(folder / "Res.dat", "64 48\n32 24\n")
    return folder


def written(path, text):
    path.write_text(text)
    return path
