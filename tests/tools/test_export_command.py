"""`export` as a user types it: tables, lines and files for viewers."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest
from tests.tools.recorded_show import FRAMES, cut_short, recorded

import followspot as fs
from followspot.cli.main import main
from followspot.room import Room
from followspot_record.recorded_rows import headings

TRACKS = "frame,time,object,state,x,y,z,vx,vy,vz,sx,sy,sz"


@pytest.fixture(scope="module")
def show(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded(tmp_path_factory.mktemp("show"))


def test_ports_become_tables_and_lines(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["export", str(show), str(tmp_path), "--to", "csv", "--ports", "track.tracks,color"]) == 0
    with (tmp_path / "track.tracks.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["frame"] for row in rows} == set(map(str, range(FRAMES)))
    assert list(rows[0])[:-2] == [*TRACKS.split(",")], "the columns of sinks.csv"
    assert list(rows[0])[-2:] == ["source", "time_ns"]
    assert all(int(row["time_ns"]) == round(1e9 * float(row["time"])) for row in rows)
    assert all(abs(float(row["z"])) < 5 for row in rows)
    assert {row["object"] for row in rows} == {"green", "red", "blue"}
    assert (tmp_path / "color.cam0.out.csv").exists()
    assert main(["export", str(show), str(tmp_path), "--to", "jsonl", "--json"]) == 0
    lines = (tmp_path / "track.forecast.jsonl").read_text().splitlines()
    assert len(lines) == FRAMES
    assert [row["object"] for row in json.loads(lines[0])["rows"]] == ["green", "red", "blue"]
    assert not list(tmp_path.glob("camera*"))


def test_an_export_replaces_no_file(show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    edited = tmp_path / "track.tracks.csv"
    edited.write_text("edited by hand\n")
    words = ["export", str(show), str(tmp_path), "--to", "csv", "--ports"]
    assert main([*words, "track"]) == 2
    said = capsys.readouterr().err
    assert f"{edited} exists already" in said
    assert "name another folder, or remove it" in said
    assert [path.name for path in tmp_path.iterdir()] == [edited.name], "nothing is written then"
    assert edited.read_text() == "edited by hand\n"
    assert main([*words, "track.forecast"]) == 0


def test_parquet_has_the_rows_of_the_table_with_their_types(show: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    for form in ("csv", "parquet"):
        ports = ["--ports", "track,verify"]
        assert main(["export", str(show), str(tmp_path), "--to", form, *ports]) == 0
    for port in ("track.tracks", "track.forecast", "verify.out"):
        with (tmp_path / f"{port}.csv").open(newline="") as file:
            lines = list(csv.DictReader(file))
        table = parquet.read_table(tmp_path / f"{port}.parquet")
        assert table.num_rows == len(lines) > 0
        assert table.column_names == list(lines[0])
    assert str(table.schema.field("epipolar").type) == "double"
    assert table["epipolar"].to_pylist() == [float(line["epipolar"]) for line in lines]


def test_a_file_for_the_rerun_viewer_is_written(show: Path, tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    ports = ["--ports", "track.tracks,camera/cam0,color/cam0,verify"]
    assert main(["export", str(show), str(tmp_path), "--to", "rerun", *ports]) == 0
    sizes = {path.name: path.stat().st_size for path in tmp_path.iterdir()}
    assert sizes.keys() == {"track.tracks.rrd", "camera.cam0.out.rrd", "color.cam0.out.rrd", "verify.out.rrd"}
    assert all(path.read_bytes().startswith(b"RRF") for path in tmp_path.iterdir())
    assert sizes["camera.cam0.out.rrd"] > sizes["track.tracks.rrd"] > 1000


def test_a_recording_that_is_cut_short_is_told_to_scripts_and_by_export(
    show: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    start = tmp_path / "start.mcap"
    start.write_bytes(show.read_bytes()[:4000])
    half = cut_short(show, tmp_path / "half.mcap", "/followspot/track/tracks", FRAMES // 2)
    with (
        fs.open_recording(half) as recording,
        pytest.warns(UserWarning, match=r"half\.mcap: .*byte"),
    ):
        assert len([*recording["track.tracks"]]) == FRAMES // 2
    with pytest.warns(UserWarning, match=r"start\.mcap"):
        fs.open_recording(start).close()
    assert main(["export", str(start), str(tmp_path / "out"), "--to", "csv"]) == 2
    assert "start.mcap: " in capsys.readouterr().err.replace(f"{start} has no such ports", "")


class Timed(fs.Message):
    """A field with the name of a column that every table has, and a number for all rows."""

    time: float
    seen: fs.Array = fs.column("N", dtype="i4")
    level: fs.Array = fs.column()


def test_a_table_has_the_types_of_fields_under_other_names_and_of_single_numbers() -> None:
    codes = headings(Timed, Room())
    assert (codes["message_time"], codes["seen"], codes["level"]) == ("f8", "<i4", "<f8")
