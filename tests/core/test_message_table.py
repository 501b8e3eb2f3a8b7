"""A message says its table once: names instead of indices, a row for each row."""

from __future__ import annotations

import json

import numpy as np
import pytest

from followspot import Header, Room, Target
from followspot.errors import FollowspotError
from followspot.message_table import as_json, head_of, rows_of, table_of
from followspot.messages import Array, Message, column, stamped
from followspot.people import Poses
from followspot.tracking import Blobs, Candidates, Forecast, Positions, Tracks, Truth

ROOM = Room(targets={name: Target(name, 0.1) for name in ("green", "red")})
HEADER = Header("find/cam0", 3, 100_000_000)
POSES = "person x y z_head_top phi r torso_heading head_pan head_tilt confidence camera"


class Marks(Message):
    """Named points of one picture, with all that a column may be."""

    camera: str
    labels: tuple[str, ...]
    label: Array = column("N", dtype="i4", refers="labels")
    xy: Array = column("N", 2, unit="px")
    color: Array = column("N", 3, names="red green blue")
    sigma: Array = column("N", 2, 2)
    code: Array = column("N", "B", dtype="u1")
    size: Array = column(2, dtype="i4")


def marks(*label: int) -> Marks:
    n = len(label)
    values = np.arange(4.0 * n).reshape(n, 4)
    message = Marks(
        camera="cam0",
        labels=("nose", "tail"),
        label=np.array(label, "i4"),
        xy=values[:, :2],
        color=np.full((n, 3), np.nan),
        sigma=values.reshape(n, 2, 2),
        code=np.ones((n, 3), "u1"),
        size=np.array([64, 48], "i4"),
    )
    return stamped(message, HEADER)


def names(kind: type[Message]) -> str:
    return " ".join(cells.name for cells in head_of(kind, ROOM) if not cells.extra)


def test_a_table_has_names_for_indices_and_a_column_for_each_number() -> None:
    table = table_of(marks(1, 0, 7), ROOM)
    assert names(Marks) == (
        "camera label x y red green blue sigma_0_0 sigma_0_1 sigma_1_0 sigma_1_1 code size"
    )
    rows = list(rows_of(table))
    assert [row[:4] for row in rows] == [
        ("cam0", "tail", 0.0, 1.0),
        ("cam0", "nose", 4.0, 5.0),
        ("cam0", "7", 8.0, 9.0),
    ]
    assert rows[0][4:] == (None, None, None, 0.0, 1.0, 2.0, 3.0, [1, 1, 1], [64, 48])


def test_json_has_an_object_for_each_row_and_single_values_once() -> None:
    found = as_json(marks(1), ROOM)
    (row,) = found.pop("rows")
    assert found == {
        **{"type": "Marks", "source": "find/cam0", "seq": 3, "time": 100_000_000},
        **{"camera": "cam0", "labels": ("nose", "tail")},
    }
    assert (row["label"], row["x"], row["red"], row["code"]) == ("tail", 0.0, None, [1, 1, 1])
    assert as_json(marks(), ROOM)["rows"] == []


class Wave(Message):
    """Complex numbers, which neither JSON nor Parquet has."""

    peak: Array = column("N", dtype="c8")
    mean: Array = column(1, dtype="c16")


def test_a_complex_number_is_a_list_of_its_two_parts() -> None:
    wave = stamped(Wave(np.array([1 + 2j, np.nan], "c8"), np.array([3j])), HEADER)
    assert [*rows_of(table_of(wave, ROOM))] == [([1.0, 2.0], [[0.0, 3.0]]), ([None, 0.0], [[0.0, 3.0]])]
    assert json.loads(json.dumps(as_json(wave, ROOM)))["rows"][0] == {
        "peak": [1.0, 2.0],
        "mean": [[0.0, 3.0]],
    }


def test_shipped_types_have_the_columns_of_their_files() -> None:
    assert names(Tracks) == "object state x y z vx vy vz sx sy sz"
    assert names(Blobs) == "camera target u v area similarity"
    assert names(Poses) == POSES
    assert names(Truth) == "object x y z hidden trackable pair"
    assert names(Positions).startswith("object x y z covariance_0_0")
    assert names(Forecast).startswith("period object state x y z velocity_0")
    assert "view_0 view_1" in names(Candidates)


@pytest.mark.parametrize("kind", [Tracks, Blobs, Poses, Truth, Positions, Forecast, Candidates, Marks])
def test_names_do_not_depend_on_the_rows(kind: type[Message]) -> None:
    from followspot.testing.samples import BLACK, sample
    from followspot.testing.tiny_room import tiny_room

    if kind is not Marks:
        room = tiny_room()
        full = table_of(sample(kind, "plausible", room, "cam0", BLACK), room)
        assert [cells.name for cells in full] == [cells.name for cells in head_of(kind, room)]
        assert len({len(cells.values) for cells in full}) == 1


def test_a_target_that_the_room_does_not_have_is_its_number() -> None:
    """A marker with id 7 in a room of two targets ended the run with an IndexError."""
    place = np.zeros((3, 3))
    tracks = Tracks(np.array([7, 1, -1], "i4"), np.array([1, 2, 200], "u1"), place, place, place)
    named = [row[:2] for row in rows_of(table_of(tracks, ROOM))]
    assert named == [("7", "tracked"), ("red", "missing"), ("-1", "200")]


def test_a_blob_that_may_be_no_target_keeps_its_row() -> None:
    mask = np.array([[True, True], [False, False]])
    blobs = Blobs("cam0", np.zeros((2, 2)), np.ones((2, 2)), np.ones(2), np.ones(2), mask)
    assert [row[1] for row in rows_of(table_of(blobs, ROOM))] == ["green", "red", ""]


def test_no_column_is_named_like_another_or_like_what_stands_before_it() -> None:
    class Sample(Message):
        time: float
        xy: Array = column("N", 2)
        x: Array = column("N")
        frame: Array = column("N", dtype="i4")
        rows: Array = column("N", "B")

    assert names(Sample) == "message_time xy_x xy_y x message_frame message_rows"
    message = stamped(Sample(0.5, np.ones((1, 2)), np.zeros(1), np.ones(1, "i4"), np.ones((1, 1))), HEADER)
    found = as_json(message, ROOM)
    assert (found["time"], found["message_time"]) == (HEADER.time, 0.5)
    assert found["rows"] == [{"xy_x": 1.0, "xy_y": 1.0, "x": 0.0, "message_frame": 1, "message_rows": [1.0]}]


def test_two_columns_that_a_type_names_alike_are_refused() -> None:
    class Twice(Message):
        xy: Array = column("N", 2, names="x y")
        other: Array = column("N", names="x")

    with pytest.raises(FollowspotError, match=r"Twice has two columns x; give them names"):
        head_of(Twice, ROOM)


def test_a_reference_to_nothing_is_refused() -> None:
    with pytest.raises(TypeError, match="label refers to lables: neither targets, states nor a field"):
        type(
            "Wrong",
            (Message,),
            {"__annotations__": {"label": Array}, "label": column("N", dtype="i4", refers="lables")},
        )


class Level(Message):
    """Numbers without rows."""

    level: Array = column(unit="m")
    below: Array = column("N")


class Spread(Message):
    """Rows, and a number for all of them."""

    place: Array = column("N")
    sigma: Array = column()


def test_a_column_of_a_single_number_is_a_value_of_each_row() -> None:
    level = stamped(Level(np.array(1.5), np.array([0.5, 1.0])), HEADER)
    assert names(Level) == "level below"
    assert list(rows_of(table_of(level, ROOM))) == [(1.5, [0.5, 1.0])]
    spread = stamped(Spread(np.array([1.0, 2.0]), np.array(np.nan)), HEADER)
    assert as_json(spread, ROOM)["rows"] == [{"place": 1.0, "sigma": None}, {"place": 2.0, "sigma": None}]
