"""Tracks and blobs as CSV files."""

from pathlib import Path

import numpy as np
import pytest
from tests.full_disk import full_disk

from followspot import Context, FollowspotError, Header, InputError, Room, Target
from followspot.inertial import PosedTracks
from followspot.messages import stamped
from followspot.tracking import Blobs, Tracks
from followspot_accuracy import read_tracks_csv
from followspot_sinks.csv_file import CsvFile

ROOM = Room(targets={"green": Target("green", 0.1), "red": Target("red", 0.1)})


def tracks(seq: int, time: int, rows: int = 2) -> Tracks:
    xyz = np.array([[1.5, -2.25, 1 / 3], [0.0, 0.1, 2.0]])[:rows]
    message = Tracks(
        target=np.array([1, 0], "i4")[:rows],
        state=np.array([1, 3], "u1")[:rows],
        xyz=xyz,
        velocity=xyz / 2,
        sigma=np.abs(xyz) / 100,
    )
    return stamped(message, Header("track", seq, time))


def saved(folder: Path, *messages: Tracks, resumed: bool = False, columns: tuple[str, ...] = ()) -> Path:
    receives = () if messages else (Tracks,)
    sink = CsvFile(Context(room=ROOM, out=folder, resumed=resumed, receives=receives), columns=columns)
    sink.setup()
    for message in messages:
        sink.process((message,))
    sink.close()
    return folder / "tracks.csv"


def test_tracks_are_one_row_per_target_and_frame(tmp_path: Path) -> None:
    lines = saved(tmp_path, tracks(7, 233_333_333)).read_text().splitlines()
    assert lines == [
        "frame,time,object,state,x,y,z,vx,vy,vz,sx,sy,sz",
        "7,0.233333333,red,tracked,1.500000,-2.250000,0.333333,0.750000,-1.125000,0.166667,0.015000,0.022500,0.003333",
        "7,0.233333333,green,predicted,0.000000,0.100000,2.000000,0.000000,0.050000,1.000000,0.000000,0.001000,0.020000",
    ]


def test_times_before_zero_are_written_as_they_are(tmp_path: Path) -> None:
    _, *rows = (
        saved(tmp_path, tracks(0, -1_250_000_000, 1), tracks(1, -250_000_000, 1)).read_text().splitlines()
    )
    assert [float(row.split(",")[1]) for row in rows] == [-1.25, -0.25]


def test_a_sink_that_is_resumed_adds_to_what_the_run_has_written(tmp_path: Path) -> None:
    whole = saved(tmp_path / "whole", tracks(0, 0), tracks(1, 10)).read_text()
    saved(tmp_path, tracks(0, 0))
    assert saved(tmp_path, tracks(1, 10), resumed=True).read_text() == whole
    assert saved(tmp_path / "new", tracks(0, 0), tracks(1, 10), resumed=True).read_text() == whole
    assert saved(tmp_path, tracks(0, 0)).read_text() != whole, "another run begins anew"


def test_after_a_checkpoint_the_next_row_reaches_the_disk_with_those_before(tmp_path: Path) -> None:
    sink = CsvFile(Context(room=ROOM, out=tmp_path))
    sink.setup()
    sink.process((tracks(0, 0),))
    assert (tmp_path / "tracks.csv").read_text() == ""
    sink.state()
    sink.process((tracks(1, 10),))
    assert len((tmp_path / "tracks.csv").read_text().splitlines()) == 5
    sink.process((tracks(2, 20),))
    assert len((tmp_path / "tracks.csv").read_text().splitlines()) == 5
    sink.close()


def test_rows_with_other_columns_are_not_added_to_a_file(tmp_path: Path) -> None:
    before = saved(tmp_path, tracks(0, 0)).read_text()
    with pytest.raises(FollowspotError, match="other columns\n    give the sink another file"):
        saved(tmp_path, resumed=True, columns=("x",))
    assert (tmp_path / "tracks.csv").read_text() == before


def test_frame_without_known_positions_has_no_row(tmp_path: Path) -> None:
    assert len(saved(tmp_path, tracks(0, 0, rows=0)).read_text().splitlines()) == 1


def test_saved_tracks_read_back(tmp_path: Path) -> None:
    table = read_tracks_csv(saved(tmp_path, tracks(0, 0), tracks(1, 1_700_000_000_123_456_789)))
    assert table.objects == ("red", "green")
    np.testing.assert_allclose(table.xyz[2:], [[1.5, -2.25, 1 / 3], [0, 0.1, 2]], atol=1e-6)
    assert table.time[2] == pytest.approx(1_700_000_000.123456789, abs=1e-6)


def test_file_ends_with_a_whole_line_also_before_close(tmp_path: Path) -> None:
    sink = CsvFile(Context(room=ROOM, out=tmp_path))
    sink.setup()
    for frame in range(500):
        sink.process((tracks(frame, frame),))
    written = (tmp_path / "tracks.csv").read_text()
    assert written.count("\n") > 900
    assert written.endswith("\n")
    sink.close()


def test_output_cannot_leave_the_output_folder(tmp_path: Path) -> None:
    for name in ("../tracks.csv", "/tmp/tracks.csv", "a/../../tracks.csv", "."):
        sink = CsvFile(Context(out=tmp_path / "run"), path=name)
        with pytest.raises(InputError, match="outside the output folder"):
            sink.setup()
        sink.close()


def test_full_disk_is_an_error_that_says_so(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("needs /dev/full")
    sink = CsvFile(Context(room=ROOM, out=Path("/dev"), receives=(Tracks,)), path="full")
    sink.setup()
    with pytest.raises(FollowspotError, match=r"/dev/full is cut short: No space left on device"):
        sink.close()


def test_a_disk_that_becomes_full_leaves_whole_rows_and_the_error_counts_the_others(tmp_path: Path) -> None:
    messages = [tracks(n, n * 10) for n in range(20)]
    whole = saved(tmp_path / "whole", *messages).read_bytes()
    for limit in (1, 1_000, whole.index(b"\n") + 1, len(whole) - 1):
        sink = CsvFile(Context(room=ROOM, out=tmp_path, receives=(Tracks,)))
        sink.setup()
        for message in messages:
            sink.process((message,))
        with full_disk(limit), pytest.raises(FollowspotError) as told:
            sink.close()
        rest = whole[: whole.rfind(b"\n", 0, limit) + 1]
        assert (tmp_path / "tracks.csv").read_bytes() == rest
        lost = whole.count(b"\n") - rest.count(b"\n")
        assert str(told.value) == (
            f"{tmp_path}/tracks.csv is cut short: File too large; {lost} lines are lost\n"
            "    raise the limit of the size of a file: ulimit -f unlimited"
        )


def test_a_file_that_is_removed_while_it_is_written_is_an_error(tmp_path: Path) -> None:
    sink = CsvFile(Context(room=ROOM, out=tmp_path))
    sink.setup()
    sink.process((tracks(0, 0),))
    (tmp_path / "tracks.csv").unlink()
    with pytest.raises(FollowspotError, match=r"tracks\.csv was removed while the run wrote it"):
        sink.close()


def test_blobs_are_one_row_per_blob_and_target(tmp_path: Path) -> None:
    blobs = Blobs(
        camera="cam0",
        xy=np.zeros((2, 2)),
        pixel=np.array([[10.25, 20.5], [30.0, 40.0]]),
        area=np.array([64.0, 12.0]),
        similarity=np.array([0.91, 1.0]),
        targets=np.array([[True, True], [False, True]]),
    )
    sink = CsvFile(Context(room=ROOM, out=tmp_path), path="blobs.csv")
    sink.setup()
    sink.process((stamped(blobs, Header("color/cam0", 3, 100_000_000)),))
    sink.close()
    assert (tmp_path / "blobs.csv").read_text().splitlines() == [
        "frame,time,camera,target,u,v,area,similarity",
        "3,0.100000000,cam0,green,10.250,20.500,64,0.9100",
        "3,0.100000000,cam0,red,10.250,20.500,64,0.9100",
        "3,0.100000000,cam0,red,30.000,40.000,12,1.0000",
    ]


def test_orientations_have_columns_of_their_own_and_are_read_back(tmp_path: Path) -> None:
    plain = tracks(0, 0)
    posed = PosedTracks(
        **{column.name: getattr(plain, column.name) for column in Tracks.columns},
        quaternion=np.array([[0.6, 0.0, 0.8, 0.0], [np.nan] * 4]),
        orientation_sigma=np.array([0.01, np.nan]),
    )
    path = saved(tmp_path, stamped(posed, plain.header))
    head, red, green = path.read_text().splitlines()
    assert head.endswith(",sx,sy,sz,qw,qx,qy,qz,orientation_sigma")
    assert red.endswith(",0.600000,0.000000,0.800000,0.000000,0.010000")
    assert green.endswith(",nan,nan,nan,nan,nan")
    found = read_tracks_csv(path).quaternion
    np.testing.assert_array_equal(found, posed.quaternion)
