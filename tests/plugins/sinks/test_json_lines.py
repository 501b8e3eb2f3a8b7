"""Any message as a line of JSON."""

import json
from pathlib import Path

import numpy as np

from followspot import Context, Header
from followspot.messages import stamped
from followspot.tracking import Positions, Truth
from followspot_sinks.json_lines import JsonLines


def lines(folder: Path, *messages: object) -> list[dict]:
    sink = JsonLines(Context(out=folder), path="deep/er.jsonl")
    sink.setup()
    for message in messages:
        sink.process((message,))
    sink.close()
    return [json.loads(line) for line in (folder / "deep/er.jsonl").read_text().splitlines()]


def test_line_holds_type_header_and_every_field(tmp_path: Path) -> None:
    truth = Truth(
        objects=("red",),
        xyz=np.array([[1.0, 2.0, 1 / 3]]),
        hidden=np.array([False]),
        trackable=np.array([True]),
        pair=np.array([True]),
    )
    assert lines(tmp_path, stamped(truth, Header("truth", 4, 133_333_333))) == [
        {
            "type": "Truth",
            "source": "truth",
            "seq": 4,
            "time": 133_333_333,
            "objects": ["red"],
            "rows": [
                {"object": "red", "x": 1.0, "y": 2.0, "z": 1 / 3, "hidden": 0, "trackable": 1, "pair": 1}
            ],
        }
    ]


def test_unknown_numbers_become_null(tmp_path: Path) -> None:
    positions = Positions.empty()
    one = Positions(
        target=np.array([0], "i4"),
        xyz=np.ones((1, 3)),
        covariance=np.full((1, 3, 3), np.nan),
        support=np.array([1], "i4"),
        confirmed=np.array([False]),
        evident=np.array([False]),
        iterations=np.array([0], "i4"),
        predicted=np.array([False]),
    )
    empty, full = lines(tmp_path, positions, one)
    assert empty["rows"] == []
    assert full["rows"][0]["covariance_2_2"] is None
