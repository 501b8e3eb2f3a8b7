"""Files of tracks and truth of targets: what is read, and what is refused."""

import math
from pathlib import Path

import numpy as np
import pytest
from tests.datasets import dataset, needs_data
from tests.plugins.accuracy.target_tables import only, still, truth

from followspot import InputError
from followspot_accuracy import (
    TrackTable,
    read_tracks_csv,
    read_truth_csv,
    score,
    table,
)
from followspot_score.command import score_files

GLOWBALLS = dataset("glowballs-dev")
needs_recordings = needs_data("glowballs-dev")


def test_empty_files_score_to_nothing(tmp_path: Path) -> None:
    path = tmp_path / "tracks.csv"
    path.write_text("frame,time,object,state,x,y,z\n")
    one = only(score(read_tracks_csv(path), truth(still(4, (0, 0, 0)))))
    assert (one.coverage, one.recovery_worst) == (0, 0)
    assert math.isnan(one.rmse_mm)


def test_unknown_state_is_named_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "tracks.csv"
    path.write_text("frame,time,object,state,x,y,z\n0,0,a,tracked,1,2,3\n1,0.1,a,found,1,2,3\n")
    with pytest.raises(InputError, match=r'tracks\.csv:3:9: "found" in column state'):
        read_tracks_csv(path)


def test_file_that_is_not_there_or_not_text_is_an_input_error(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_truth_csv(tmp_path / "none.csv")
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match=r"binary\.csv:1:1: this is not UTF-8"):
        read_truth_csv(binary)


def written(path: Path, later: float) -> tuple[Path, Path]:
    """Tracks and truth of red and blue at 10 Hz without frame numbers; in the truth blue is later, s."""
    tracks_file, truth_file = path / "tracks.csv", path / "truth.csv"
    with tracks_file.open("w") as tracked, truth_file.open("w") as true:
        tracked.write("time,object,state,x,y,z\n")
        true.write("time,object,x,y,z,hidden,trackable,pair\n")
        for k in range(10):
            for x, (name, time) in enumerate((("red", k / 10), ("blue", k / 10 + later))):
                tracked.write(f"{k / 10},{name},tracked,{x},0,1\n")
                true.write(f"{time},{name},{x},0,1,0,1,1\n")
    return tracks_file, truth_file


def test_objects_whose_times_differ_by_rounding_are_of_one_frame(tmp_path: Path) -> None:
    tracks_file, truth_file = written(tmp_path, 1e-9)
    true = read_truth_csv(truth_file)
    assert len(true.time) == 10
    assert [one.coverage for one in score(read_tracks_csv(tracks_file), true).values()] == [1.0, 1.0]


def test_a_second_row_of_an_object_in_a_frame_is_refused_with_both_lines(tmp_path: Path) -> None:
    head = "time,object,x,y,z,hidden,trackable,pair"
    times = [round(k / 1500, 3) for k in range(4)]  # 0.0007 s apart, and written in ms
    rows = [f"{time},{name},0,0,1,0,1,1" for time in times for name in ("red", "blue")]
    path = tmp_path / "truth.csv"
    path.write_text("\n".join([head, *rows]))
    told = r'(?s)truth\.csv:6:1: object "red" has a row of this frame already, in line 4.*with more digits'
    with pytest.raises(InputError, match=told):
        read_truth_csv(path)


def test_tracks_with_two_rows_of_an_object_at_one_time_are_refused_with_both_lines(tmp_path: Path) -> None:
    """As of two runs in one file, of which the order of the rows would decide which counts."""
    path = tmp_path / "tracks.csv"
    rows = ["0.0,red,tracked,0,0,1", "0.00001,red,tracked,0,0,1", "0.0,blue,tracked,0,0,1"]
    path.write_text("\n".join(["time,object,state,x,y,z", *rows]))
    assert len(read_tracks_csv(path).time) == 3, "times may be as near as they like"
    path.write_text("\n".join(["time,object,state,x,y,z", *rows, "0,red,lost,0,0,2"]))
    told = r'(?s)tracks\.csv:5:1: object "red" has a row of this frame already, in line 2.*rows of one run'
    with pytest.raises(InputError, match=told):
        read_tracks_csv(path)


def test_truth_with_a_time_for_each_object_is_refused(tmp_path: Path) -> None:
    tracks_file, truth_file = written(tmp_path, 0.02)
    with pytest.raises(InputError, match=r"(?s)blue at no time .*give all objects of a frame one time"):
        score_files(tracks_file, [truth_file], None, None, as_json=False)


@needs_recordings
def test_recorded_truth_is_perfect_against_itself() -> None:
    recorded = read_truth_csv(GLOWBALLS / "dev4/truth.csv")
    assert recorded.objects == ("yellow", "red", "blue")
    assert recorded.hidden[:, 0].sum() == (87 - 34 + 1) + (188 - 142 + 1)
    frame, target = np.nonzero(~recorded.hidden)
    states = np.ones(len(frame), "u1")
    rows = TrackTable(recorded.objects, recorded.time[frame], target, states, recorded.xyz[frame, target])
    for one in score(rows, recorded).values():
        assert (one.coverage, one.rmse_mm, one.identity_switches, one.false_positions) == (1, 0, 0, 0)
        assert one.recovery_worst == 0
        assert one.recovery_frames


def test_sigmas_are_read_from_files_and_may_be_missing(tmp_path: Path) -> None:
    path = tmp_path / "tracks.csv"
    path.write_text(
        "frame,time,object,state,x,y,z,sx,sy,sz\n0,0,a,tracked,1,2,3,.1,.2,.3\n1,1,a,tracked,1,2,3,,,\n"
    )
    found = read_tracks_csv(path).sigma
    assert found is not None
    assert found[0].tolist() == [0.1, 0.2, 0.3]
    assert np.isnan(found[1]).all()
    path.write_text("frame,time,object,state,x,y,z\n0,0,a,tracked,1,2,3\n")
    unrated = only(score(read_tracks_csv(path), truth(still(1, (1, 2, 3)))))
    assert (unrated.rated_frames, unrated.bridged_frames) == (0, 0)
    assert "95 %" not in table({"a": unrated})


def test_a_negative_sigma_is_a_mistake(tmp_path: Path) -> None:
    path = tmp_path / "tracks.csv"
    path.write_text("frame,time,object,state,x,y,z,sx,sy,sz\n0,0,a,tracked,1,2,3,.1,-.2,.3\n")
    with pytest.raises(InputError, match=r'tracks\.csv:2:24: "-\.2" in column sy'):
        read_tracks_csv(path)


def test_truth_without_rows_is_a_mistake(tmp_path: Path) -> None:
    path = tmp_path / "truth.csv"
    path.write_text("frame,time,object,x,y,z,hidden,trackable,pair\n")
    with pytest.raises(InputError, match=r"truth\.csv has no rows: there is nothing to score by"):
        read_truth_csv(path)


def test_orientations_are_read_from_files_and_may_be_missing(tmp_path: Path) -> None:
    head = "frame,time,object,state,x,y,z,qw,qx,qy,qz\n"
    rows = "0,0,red,tracked,0,0,0,nan,nan,nan,nan\n1,1,red,tracked,0,0,0,,,,\n2,2,red,tracked,0,0,0,0,0,1,0\n"
    path = tmp_path / "tracks.csv"
    path.write_text(head + rows)
    found = read_tracks_csv(path).quaternion
    assert found is not None
    assert np.isnan(found[:2]).all()
    assert found[2].tolist() == [0, 0, 1, 0]
    path.write_text(head + "0,0,red,tracked,0,0,0,1,0,0,x\n")
    with pytest.raises(InputError, match=r"tracks.csv:2:29"):
        read_tracks_csv(path)
