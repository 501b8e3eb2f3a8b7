"""Each graph in each kind of room that it promises: checked, run, run camera by camera, and swapped."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest

import followspot as fs
from bench.balls.camera_mixes import Mix, first_positions, part
from followspot import room_file

GRAPHS = Path(__file__).parents[2] / "graphs"
FRAMES = 24


@dataclass(frozen=True)
class Case:
    """mix: the part of the simulated room, None for the graph's own room.

    port: its messages say when to swap; swap: a stage, and its replacement; marked: whether the targets
    are told once by marks; planes: whether the room names its planes.
    """

    graph: str
    port: str = "track.tracks"
    swap: tuple[str, str] = ("fuse", "balls.mean")
    mix: Mix | None = None
    marked: bool = False
    planes: bool = True


BALLS = "glowballs.yaml"
CASES = {
    "3 colour and 3 infrared": Case(BALLS, mix=Mix(3, 3)),
    "2 colour and 1 infrared": Case(BALLS, mix=Mix(2, 1)),
    "1 colour and 1 infrared": Case(BALLS, mix=Mix(1, 1)),
    "3 colour": Case(BALLS, mix=Mix(3, 0)),
    "3 infrared": Case(BALLS, mix=Mix(0, 3), marked=True),
    "no planes": Case(BALLS, mix=Mix(2, 1), planes=False),
    "3 infrared, one target": Case(BALLS, mix=Mix(0, 3, targets=1)),
    "depth": Case("depth.yaml"),
    "depth, colour and infrared": Case("mixed.yaml"),
    "building": Case("building.yaml", "merge.out", ("hall/fuse", "balls.mean")),
    "building, a whole zone": Case("building.yaml", "merge.out", ("stage", str(GRAPHS / BALLS))),
    "markers": Case("markers.yaml", "poses.poses", ("poses", "vision.marker_poses")),
    "show": Case("show.yaml", "balls/track.tracks", ("balls/fuse", "balls.mean")),
}
HEAVY = {
    "building, a whole zone",
    "show",
    "depth, colour and infrared",
    "3 colour and 3 infrared",
    "2 colour and 1 infrared",
    "1 colour and 1 infrared",
    "3 colour",
    "3 infrared",
    "building",
    "markers",
}
MARKED = [
    pytest.param(case, id=name, marks=[pytest.mark.thorough] * (name in HEAVY))
    for name, case in CASES.items()
]


@pytest.mark.parametrize("case", MARKED)
def test_a_graph_in_its_room_gives_the_same_in_any_placement_and_can_be_changed(
    case: Case, tmp_path: Path
) -> None:
    options: dict[str, Any] = {"set": {}}
    if case.mix is not None:
        room = part(room_file.load(GRAPHS / "rooms/simulated.yaml"), case.mix, seed=7, frames=FRAMES)
        room = room if case.planes else replace(room, planes={})
        room_file.save(room, tmp_path / "room.yaml")
        options["room"] = tmp_path / "room.yaml"
        if case.marked:
            options["set"]["track.marks"] = first_positions(room)
    graph = GRAPHS / case.graph
    assert not [found for found in fs.check(graph, **options) if not found.warning]
    alone = written(graph, tmp_path / "alone", **options)
    assert all(text.count(b"\n") > FRAMES / 2 for text in alone.values()), "something is tracked"
    assert written(graph, tmp_path / "apart", placement="camera", **options) == alone
    with fs.run(graph, out=tmp_path / "changed", frames=FRAMES, ports=[case.port], **options) as run:
        for count, _ in enumerate(run[case.port]):
            if count == 5:
                run.swap(*case.swap)
        report = run.wait()
    assert report.ok
    assert count == FRAMES - 1
    assert all(row["in_flight"] == 0 for row in report.ledger)


def written(graph: Path, out: Path, **options: Any) -> dict[str, bytes]:
    """The files of a run, by name."""
    with fs.run(graph, out=out, frames=FRAMES, **options) as run:
        assert run.wait().ok
    return {path.name: path.read_bytes() for path in sorted(out.glob("*.csv"))}
