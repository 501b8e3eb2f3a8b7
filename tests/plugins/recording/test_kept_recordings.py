"""Recordings of earlier versions stay readable.

`kept/version_0_1.mcap`: eight frames of points of the simulated room, tracked by `graphs/points.yaml`.
`kept/pictures/version_0_1.mcap`: three pictures as differences of their rows, drawn by a formula.
A format that changes gets a file of its own beside it; this one is never made anew.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import followspot as fs
from followspot.cli.main import main
from followspot.tracking import Frame, Tracks

KEPT = Path(__file__).parent / "kept"
LAST = [[0.607472, -0.027176, 1.133843], [-0.622448, 0.070334, 1.046488], [0.438949, 0.497389, 1.095244]]
"""The places in its last message, m, as the run that was recorded wrote them into a table."""


@pytest.fixture(params=sorted(path.name for path in KEPT.glob("*.mcap")))
def kept(request: pytest.FixtureRequest) -> Path:
    return KEPT / str(request.param)


def test_a_script_reads_the_messages(kept: Path) -> None:
    with fs.open_recording(kept) as recording:
        found = list(recording["track.tracks"])
        assert set(recording) >= {"points/cam0.out", "triangulate.out", "track.tracks"}
    assert [type(message) for message in found] == [Tracks] * 8
    assert [message.header.seq for message in found] == list(range(8))
    assert found[-1].header.time == round(7e9 / 60)
    np.testing.assert_allclose(found[-1].xyz, LAST, atol=1e-6)


def test_pictures_are_those_of_the_formula() -> None:
    y, x = np.mgrid[:24, :32]
    with fs.open_recording(KEPT / "pictures" / "version_0_1.mcap") as recording:
        found = [message for message in recording["camera/cam0.out"] if isinstance(message, Frame)]
    for number, message in enumerate(found):
        drawn = np.stack([7 * y + number, 3 * x, x * y], axis=2).astype("u1")
        np.testing.assert_array_equal(message.pixels, drawn)
    assert len(found) == 3


def test_its_graph_runs_on_its_sources(kept: Path, tmp_path: Path) -> None:
    assert main(["replay", str(kept), "--out", str(tmp_path), "--quiet"]) == 0
    rows = (tmp_path / "tracks.csv").read_text().splitlines()
    assert len(rows) > 8, "a row for each target and frame"


def test_its_ports_become_tables(kept: Path, tmp_path: Path) -> None:
    assert main(["export", str(kept), "--to", "csv", str(tmp_path / "tables")]) == 0
    text = (tmp_path / "tables" / "track.tracks.csv").read_text()
    assert text.splitlines()[0].startswith("frame,time,object,state,x,y,z,")
    assert {"red", "green", "blue"} <= set(text.replace("\n", ",").split(","))
