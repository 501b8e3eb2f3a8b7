"""Tracks in pictures as a CSV file."""

from pathlib import Path

import numpy as np

from followspot import Context, Header, Room, Target
from followspot.messages import stamped
from followspot.tracking import ImageTracks
from followspot_sinks.csv_file import CsvFile

ROOM = Room(targets={"green": Target("green", 0.1), "red": Target("red", 0.1)})


def test_image_tracks_are_one_row_per_track_at_its_place_in_the_picture(tmp_path: Path) -> None:
    tracks = ImageTracks(
        camera="cam0",
        target=np.array([1, 0], "i4"),
        track=np.array([4, 7], "i4"),
        xy=np.zeros((2, 2)),
        pixel=np.array([[10.25, 20.5], [30.0, 40.0]]),
        velocity=np.array([[1.0, -2.0], [0.5, 300.0]]),
        residual=np.array([0.75, 1 / 3]),
    )
    sink = CsvFile(Context(room=ROOM, out=tmp_path), path="image_tracks.csv")
    sink.setup()
    sink.process((stamped(tracks, Header("throws/cam0", 3, 100_000_000)),))
    sink.process((stamped(ImageTracks.empty(), Header("throws/cam0", 4, 133_333_333)),))
    sink.close()
    assert (tmp_path / "image_tracks.csv").read_text().splitlines() == [
        "frame,time,camera,target,track,u,v,du,dv,residual",
        "3,0.100000000,cam0,red,4,10.250,20.500,1.000,-2.000,0.750",
        "3,0.100000000,cam0,green,7,30.000,40.000,0.500,300.000,0.333",
    ]
