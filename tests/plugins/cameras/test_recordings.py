"""Which recording belongs to which camera."""

from pathlib import Path

import pytest

from followspot import InputError
from followspot_cameras.recordings import find_recordings


def test_recordings_are_found_by_the_cameras_name(tmp_path: Path) -> None:
    (tmp_path / "cam0.mkv").touch()
    (tmp_path / "cam1.MP4").touch()
    (tmp_path / "cam2").mkdir()
    (tmp_path / "cam3.txt").touch()
    found = find_recordings(tmp_path, ["cam0", "cam1", "cam2", "cam3"])
    assert {name: path.name for name, path in found.items()} == {
        "cam0": "cam0.mkv",
        "cam1": "cam1.MP4",
        "cam2": "cam2",
    }


def test_two_videos_of_one_camera_are_refused(tmp_path: Path) -> None:
    (tmp_path / "cam0.mkv").touch()
    (tmp_path / "cam0.avi").touch()
    with pytest.raises(InputError, match=r"camera cam0 has several videos: cam0\.avi, cam0\.mkv"):
        find_recordings(tmp_path, ["cam0"])


def test_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is not a folder"):
        find_recordings(tmp_path / "none", ["cam0"])
