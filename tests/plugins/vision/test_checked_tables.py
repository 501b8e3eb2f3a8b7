"""`followspot check` looks at the first rows of tables that other programs wrote."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from followspot import Context, InputError, Member, room_file
from followspot.errors import Mistake
from followspot.graph.compile import compile_graph
from followspot.stage import Stage
from followspot.testing import tiny_room
from followspot_vision.keypoints_json import KeypointsJson
from followspot_vision.points_csv import PointsCsv

GRAPH = """\
graph: tables
room: room.yaml
stages:
  found: {uses: %s, %s with: {path: %s, %s}}
"""
POINTS = "frame,camera,x,y\n0,cam0,1,2\n0,cam1,1,2\n"
BOXES = "frame,camera,x0,y0,x1,y1\n0,cam0,1,2,3,4\n"
SPACE = "frame,x,y,z\n0,1,2,3\n"
PERSON = {"people": [{"pose_keypoints_2d": [1, 2, 0.5] * 18}]}


def checked(folder: Path, uses: str, path: str, more: str = "fps: 30") -> tuple[Mistake, ...]:
    room_file.save(tiny_room(), folder / "room.yaml")
    each = "" if "candidates" in uses else "each: cameras,"
    (folder / "graph.yaml").write_text(GRAPH % (uses, each, path, more))
    try:
        compile_graph(folder / "graph.yaml")
    except InputError as error:
        return error.mistakes
    return ()


TABLES = {
    "points": ("points_csv", POINTS),
    "boxes": ("boxes_csv", BOXES),
    "candidates": ("candidates_csv", SPACE),
}


@pytest.mark.parametrize(("stage", "text"), TABLES.values(), ids=TABLES)
def test_a_table_without_mistakes_is_fine(tmp_path: Path, stage: str, text: str) -> None:
    (tmp_path / "table.csv").write_text(text)
    assert checked(tmp_path, f"vision.{stage}", "table.csv") == ()


@pytest.mark.parametrize(
    ("stage", "text", "line", "said"),
    [
        ("points_csv", POINTS.replace(",x,", ",u,"), 1, "missing columns: x"),
        ("points_csv", POINTS.replace("cam1", "cam7"), 3, '"cam7" in column camera'),
        ("points_csv", POINTS.replace("cam0,1", "cam0,one"), 2, '"one" in column x'),
        ("points_csv", POINTS.replace("frame", "number"), 1, "neither a column frame nor a column time"),
        ("points_csv", POINTS + "0,cam0\n", 4, "2 columns, 4 needed"),
        ("boxes_csv", BOXES.replace("3,4", "0,4"), 2, '"0" in column x1'),
        ("boxes_csv", BOXES.replace("cam0", "cam7"), 2, '"cam7" in column camera'),
        ("candidates_csv", SPACE.replace("3\n", "far\n"), 2, '"far" in column z'),
    ],
)
def test_a_mistake_in_the_first_rows_is_told_once_with_its_line_and_the_graph(
    tmp_path: Path, stage: str, text: str, line: int, said: str
) -> None:
    (tmp_path / "table.csv").write_text(text)
    (mistake,) = checked(tmp_path, f"vision.{stage}", "table.csv")
    assert said in mistake.text
    assert mistake.place is not None
    assert (Path(mistake.place.file).name, mistake.place.line) == ("table.csv", line)
    assert [Path(place.file).name for place in mistake.place.outer_places] == ["graph.yaml"]


def warned(folder: Path, uses: str, path: str, more: str) -> tuple[Mistake, ...]:
    room_file.save(tiny_room(), folder / "room.yaml")
    (folder / "graph.yaml").write_text(GRAPH % (uses, "each: cameras,", path, more))
    found = compile_graph(folder / "graph.yaml").warnings
    return tuple(one for one in found if "shares" in one.text)


def row(places: list[float]) -> str:
    return ",".join(map(str, places))


PLACES = {
    "points_csv": ("x,y", [[0.5, 0.25], [0.75, 1.0]], [[320, 120], [480, 480]]),
    "boxes_csv": ("x0,y0,x1,y1", [[0.1, 0.2, 0.3, 0.4]], [[64, 96, 192, 192]]),
}


@pytest.mark.parametrize("stage", PLACES)
def test_shares_that_are_taken_for_pixels_are_told_with_their_file_line_and_parameter(
    tmp_path: Path, stage: str
) -> None:
    columns, shares, pixels = PLACES[stage]
    both = [f"0,{camera},{row(one)}\n" for camera in ("cam0", "cam1") for one in shares]
    (tmp_path / "both.csv").write_text(f"frame,camera,{columns}\n" + "".join(both))
    (mistake,) = warned(tmp_path, f"vision.{stage}", "both.csv", "fps: 30")
    assert mistake.place is not None
    assert (Path(mistake.place.file).name, mistake.place.line) == ("both.csv", 2)
    assert "shares" in mistake.text
    assert mistake.remedy == "with: {unit: share}"
    assert warned(tmp_path, f"vision.{stage}", "both.csv", "fps: 30, unit: share") == ()
    mixed = f"frame,camera,{columns}\n" + "".join(f"0,cam0,{row(one)}\n" for one in [*shares, *pixels])
    (tmp_path / "mixed.csv").write_text(mixed)
    assert warned(tmp_path, f"vision.{stage}", "mixed.csv", "fps: 30") == (), "some lie in the corner"


@pytest.mark.parametrize("stage", PLACES)
def test_pixels_that_are_taken_for_shares_are_refused(tmp_path: Path, stage: str) -> None:
    columns, shares, pixels = PLACES[stage]
    text = f"frame,camera,{columns}\n" + "".join(f"0,cam0,{row(one)}\n" for one in [*shares, *pixels])
    (tmp_path / "table.csv").write_text(text)
    (mistake,) = checked(tmp_path, f"vision.{stage}", "table.csv", "fps: 30, unit: share")
    assert mistake.place is not None
    assert (Path(mistake.place.file).name, mistake.place.line) == ("table.csv", 2 + len(shares))
    assert "{unit: px}" in mistake.remedy


def test_joints_in_another_unit_are_told(tmp_path: Path) -> None:
    shares = {"people": [{"pose_keypoints_2d": [0.5, 0.25, 0.5] * 18}]}
    (tmp_path / "shares.json").write_text(json.dumps([{"image_id": 0, "keypoints": [0.5, 0.25, 0.9] * 17}]))
    (tmp_path / "pixels.json").write_text(json.dumps([{"image_id": 0, "keypoints": [320, 120, 0.9] * 17}]))
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "cam_000000000000_keypoints.json").write_text(json.dumps(shares))
    for name in ("shares.json", "folder"):
        (mistake,) = warned(tmp_path, "vision.keypoints_json", name, "fps: 30")
        assert (mistake.place is not None and mistake.place.line, mistake.remedy) == (
            4,
            "with: {unit: share}",
        )
        assert warned(tmp_path, "vision.keypoints_json", name, "fps: 30, unit: share") == ()
    assert warned(tmp_path, "vision.keypoints_json", "pixels.json", "fps: 30") == ()
    (mistake,) = checked(tmp_path, "vision.keypoints_json", "pixels.json", "fps: 30, unit: share")
    assert "nose of person 0 of a picture is at 320, 120" in mistake.text
    assert "{unit: px}" in mistake.remedy


def test_what_has_no_line_is_told_where_the_path_is_written(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text(POINTS)
    (mistake,) = checked(tmp_path, "vision.points_csv", "table.csv", "time_unit: ms")
    assert "has no column time" in mistake.text
    assert mistake.place is not None
    assert (Path(mistake.place.file).name, mistake.place.line) == ("graph.yaml", 4)


def test_later_rows_are_left_to_the_run(tmp_path: Path) -> None:
    rows = "".join(f"{n},cam0,1,2\n" for n in range(1, 200))
    (tmp_path / "table.csv").write_text(f"{POINTS}{rows}200,cam0,one,2\n")
    assert checked(tmp_path, "vision.points_csv", "table.csv") == ()


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        ("cam0.json", "[{}", "this is not JSON"),
        ("cam0.json", "{}", "is no list of results"),
        ("cam0.json", json.dumps([{"image_id": 1, "keypoints": [1, 2, 0.5] * 3}]), "3 joints"),
        ("cam1/p_000000000001_keypoints.json", "{}", "has no list people"),
        ("cam1/p_000000000001_keypoints.json", json.dumps(PERSON).replace("0.5", "null"), "number"),
    ],
)
def test_keypoints_are_looked_at(tmp_path: Path, file: str, text: str, said: str) -> None:
    path = tmp_path / "found" / file
    path.parent.mkdir(parents=True)
    path.write_text(text)
    (mistake,) = checked(tmp_path, "vision.keypoints_json", "found")
    assert said in mistake.text
    assert mistake.place is not None
    assert "graph.yaml" in {Path(p.file).name for p in (mistake.place, *mistake.place.outer_places)}


def test_keypoints_without_mistakes_and_large_files_are_fine(tmp_path: Path) -> None:
    folder = tmp_path / "found" / "cam0"
    folder.mkdir(parents=True)
    (folder / "p_000000000001_keypoints.json").write_text(json.dumps(PERSON))
    (folder / "p_000000000002_keypoints.json").write_text("{}")
    (tmp_path / "found" / "cam1.json").write_text("{" + " " * 2_000_000)
    assert checked(tmp_path, "vision.keypoints_json", "found") == ()


def test_a_check_that_fails_itself_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(cls: type[Stage], *_: object) -> None:
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(PointsCsv, "check_files", classmethod(broken))
    (tmp_path / "table.csv").write_text(POINTS)
    (mistake,) = checked(tmp_path, "vision.points_csv", "table.csv")
    assert mistake.text == "vision.points_csv.check_files failed: ZeroDivisionError: oh"


def test_results_of_one_camera_are_no_pictures_of_another(tmp_path: Path) -> None:
    found = tmp_path / "found"
    found.mkdir()
    (found / "cam0.json").write_text(json.dumps([{"image_id": 1, "keypoints": [1, 2, 0.5] * 17}]))
    assert checked(tmp_path, "vision.keypoints_json", "found") == ()
    told: list[str] = []
    stage = KeypointsJson(
        Context("joints", tiny_room(), Member("cameras", "cam1"), warn=told.append), path=found, fps=30
    )
    stage.setup()
    assert (stage.length(), told) == (0, [f"{found} has no results"])
