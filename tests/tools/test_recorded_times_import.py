"""`followspot room import` finds the capture times that lie beside recordings."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

from followspot import Camera, Room
from followspot_cameras.recorded_times.beside import spread_of_moments, times_beside
from followspot_room.format import Calibration
from followspot_room.importing import room_of, with_spread

TABLE = "sync_index,cam_id,frame_time\n0,cam0,1\n0,cam1,1.0101\n1,cam0,2\n1,cam1,2\n"


def pictures(folder: Path) -> dict[str, Path]:
    for name in ("cam0", "cam1"):
        (folder / name).mkdir(parents=True)
        for number in range(2):
            cv2.imwrite(str(folder / name / f"{number}.png"), np.zeros((48, 64), "u1"))
    return {name: folder / name for name in ("cam0", "cam1")}


def test_a_list_of_its_own_goes_before_the_table_of_all(tmp_path: Path) -> None:
    recordings = pictures(tmp_path)
    assert times_beside("cam0", recordings["cam0"]) is None
    (tmp_path / "timestamps.csv").write_text("sync_index,cam_id\n0,cam0\n")
    assert times_beside("cam0", recordings["cam0"]) is None
    (tmp_path / "timestamps.csv").write_text(TABLE)
    (tmp_path / "cam1.pts").write_text("# timestamp format v2\n0\n9\n")
    assert times_beside("cam0", recordings["cam0"]) == tmp_path / "timestamps.csv"
    assert times_beside("cam1", recordings["cam1"]) == tmp_path / "cam1.pts"
    assert spread_of_moments(tmp_path / "timestamps.csv", recordings) == 10_100_000


def test_an_imported_room_takes_times_from_the_table(tmp_path: Path) -> None:
    recordings = pictures(tmp_path / "takes")
    (tmp_path / "takes/timestamps.csv").write_text(TABLE)
    eye = np.eye(3)
    cameras = tuple(
        Camera(name, "color", (64, 48), eye, np.zeros(5), eye, np.zeros(3)) for name in recordings
    )
    known = with_spread(Calibration(cameras), recordings)
    assert known.notes == (
        "by timestamps.csv, pictures of one moment were taken up to 11 ms apart; stages match them with a "
        "tolerance of 0.011 and more",
    )
    room = room_of(known, recordings, None, tmp_path / "room.yaml", Room())
    assert room.cameras["cam1"].source is not None
    assert room.cameras["cam1"].source.params == {"path": "takes/cam1", "times": "takes/timestamps.csv"}
