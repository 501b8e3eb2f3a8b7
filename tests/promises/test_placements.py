"""Placement never changes the result: every file, every message of every port, every figure, bit for bit."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest
from tests.promises.made_rooms import MADE, ROOMS
from tests.promises.played import Played, burners, differences, one_each, play

GRAPHS = Path(__file__).parents[2] / "graphs"
SHOWN = """
  drawn: {uses: sinks.draw, in: {frames: camera%s}, with: {format: png}}
"""
"""What is drawn is written as pictures, which lose nothing."""
BALLS = """
  color_seen: {uses: sinks.csv, in: {blobs: color}, with: {path: color.csv}}
  infrared_seen: {uses: sinks.csv, in: {blobs: infrared}, with: {path: infrared.csv}}
  forecast: {uses: sinks.jsonl, in: {message: track.forecast}, with: {path: forecast.jsonl}}
"""


@dataclass(frozen=True)
class Case:
    """A shipped graph in a room: a shipped one, or one that `rooms.MADE` makes from such.

    more: sinks beside its own; split: placement of two workers.
    """

    graph: str
    room: str
    frames: int
    more: str = ""
    split: str = "placements/two.yaml"
    plugin: str = ""


CASES = {
    "glowballs": Case("glowballs.yaml", "simulated", 200, BALLS + SHOWN % ", tracks: track"),
    "glowballs, six balls": Case("glowballs.yaml", "simulated6", 120, BALLS),
    "glowballs, bright": Case("glowballs.yaml", "simulated_bright", 120, BALLS),
    "glowballs, not synchronised": Case("glowballs.yaml", "simulated_unsynchronised", 120, BALLS),
    "panorama": Case(
        "person_panorama.yaml", "simulated_panorama", 30, SHOWN % ", poses: pose", "placements/person.yaml"
    ),
    "persons": Case(
        "person_room.yaml", "simulated_persons", 24, SHOWN % ", poses: fuse", "placements/person.yaml"
    ),
    "throws": Case("throws.yaml", "one camera", 200, split=""),
    "single camera": Case("single_camera.yaml", "one camera", 200, "  draw: {with: {format: png}}", split=""),
    "videos": Case("glowballs.yaml", "videos", 90, BALLS),
    "pictures": Case("glowballs.yaml", "pictures", 60, BALLS),
    "recording": Case("glowballs.yaml", "recording", 90, BALLS),
    "recorded": Case("experiments/recorded.yaml", "simulated", 120),
    "search gate": Case("experiments/search_gate.yaml", "simulated", 120),
    "blind": Case(
        "experiments/persons.yaml",
        "simulated_panorama",
        15,
        split="placements/person.yaml",
        plugin="experiments/detectors.py",
    ),
}
PLACED = ("", "camera", "stage", "two", "each")
WAYS = [(placed, edges) for placed in PLACED for edges in ("ring", "zenoh")]


@dataclass
class Stand:
    """A case with its files, played once in one process."""

    case: Case
    graph: Path
    options: tuple[str, ...]
    record: bool
    once: Played

    def play(self, folder: Path, placed: str, edges: str) -> Played:
        """The same, elsewhere."""
        split = str(GRAPHS / self.case.split) if self.case.split else "camera"
        names = {"two": split, "each": str(folder / "each.yaml")}
        (folder / "each.yaml").write_text(one_each(self.once.stages))
        placement = ("--placement", names.get(placed, placed)) if placed else ()
        options = (*self.options, *placement, "--edges", edges)
        return play(self.graph, folder, *options, record=self.record)


def stand(case: Case, folder: Path, *, record: bool) -> Stand:
    """Write the graph with the sinks that it gets beside its own, and play it in one process."""
    graph = folder / "graph.yaml"
    more = case.more or "  {}"
    graph.write_text(f"graph: g\nextends: {GRAPHS / case.graph}\nstages:\n{more}\n")
    room = MADE[case.room](folder) if case.room in MADE else ROOMS / f"{case.room}.yaml"
    options = ("--room", str(room), "--frames", str(case.frames))
    if case.plugin:
        options += ("--plugin", str(GRAPHS / case.plugin))
    return Stand(case, graph, options, record, play(graph, folder, *options, record=record))


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Stand:
    """The demo, with the sinks that tell most of what its stages send."""
    case = Case("glowballs.yaml", "simulated", 60, BALLS)
    return stand(case, tmp_path_factory.mktemp("demo"), record=False)


@pytest.mark.parametrize(
    "way",
    [
        pytest.param(("two", "zenoh"), id="two zenoh", marks=pytest.mark.thorough),
        pytest.param(("camera", "ring"), id="camera ring"),
    ],
)
def test_the_demo_gives_the_same_bytes_in_processes_of_its_own(
    demo: Stand, tmp_path: Path, way: tuple[str, str]
) -> None:
    assert demo.once.report["frames"] == 60
    assert {"tracks.csv", "color.csv", "infrared.csv", "forecast.jsonl"} <= set(demo.once.files)
    assert not differences(demo.once, demo.play(tmp_path, *way))


@pytest.fixture(scope="module", params=CASES)
def each(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Stand:
    """Each case in turn, with the pictures as they are."""
    return stand(CASES[request.param], tmp_path_factory.mktemp("each"), record=True)


@pytest.mark.thorough
@pytest.mark.parametrize("way", WAYS, ids=" ".join)
def test_every_graph_gives_the_same_bytes_in_every_placement(
    each: Stand, tmp_path: Path, way: tuple[str, str]
) -> None:
    assert each.once.files
    assert all(each.once.ports.values())
    assert not differences(each.once, each.play(tmp_path, *way))


@pytest.mark.thorough
@pytest.mark.parametrize("way", [("", "auto"), ("camera", "ring"), ("stage", "zenoh")], ids=" ".join)
def test_every_graph_gives_the_same_bytes_while_others_burn_the_processors(
    each: Stand, tmp_path: Path, way: tuple[str, str]
) -> None:
    with burners(2):
        found = each.play(tmp_path, *way)
    assert not differences(each.once, found)
