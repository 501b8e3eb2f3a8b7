"""A plan travels to other processes unchanged, and people can see it."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from collections import defaultdict
from collections.abc import Hashable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from tests.core.graph.files import TOY, write

from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.drawing import text as show
from followspot.graph.drawing.outline import outline
from followspot.graph.drawing.svg import svg
from followspot.graph.drawing.svg_layout import HEIGHT, Layout, Point, layout
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data, plan_to_data

GRAPHS = Path(__file__).parents[3] / "graphs"


@pytest.fixture
def plan(tmp_path: Path) -> Plan:
    return compile_graph(write(tmp_path), placement=tmp_path / "placement.yaml", plugin_files=[TOY])


def test_a_plan_that_travels_is_the_same(plan: Plan) -> None:
    data = json.loads(json.dumps(plan_to_data(plan)))
    found = plan_from_data(data)
    assert plan_to_data(found) == data
    assert (found.stages, found.edges, found.workers) == (plan.stages, plan.edges, plan.workers)
    assert (found.graph, found.seed, found.plugin_files, found.notes) == ("play", 7, (TOY,), plan.notes)


@pytest.mark.parametrize(
    ("path", "value", "said"),
    [
        (("version",), 99, "the plan has version 99"),
        (("stages", 0, "worker"), "nobody", "speaks of nobody"),
        (("edges", 0, "to_stage"), "nobody", "speaks of nobody"),
        (("edges", 0, "kind"), "pigeon", r"edges\.0\.kind"),
        (("edges", 0, "delay"), "x", r"edges\.0\.delay"),
        (("stages", 0, "on_error"), "cry", r"stages\.0\.on_error"),
        (("stages", 1, "name"), "camera/cam0", "a name stands for two"),
        (("room", "cameras", "cam0", "size"), [0, 0], "whole pixels"),
        (("stages",), None, "this is no plan: stages"),
    ],
)
def test_data_that_is_no_plan_is_refused(plan: Plan, path: tuple[Any, ...], value: Any, said: str) -> None:
    data = plan_to_data(plan)
    inner: Any = data
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    with pytest.raises(FollowspotError, match=said):
        plan_from_data(data)


def test_text_names_every_worker_stage_and_kind(plan: Plan) -> None:
    lines = show.text(plan).splitlines()
    assert lines[0] == "play in stage: 7 stages, 8 edges, 3 workers"
    assert "worker left on pc-left" in lines
    assert "  camera  toy.camera  cam0" in lines
    assert "  pair.out        -> track.blobs      reference" in lines
    assert "  track.forecast  -> detect.forecast  zenoh, delay 1 (main to left)" in lines


def test_an_edge_that_drops_is_shown_with_its_policy_and_blocks_in_a_replay(tmp_path: Path) -> None:
    graph = write(tmp_path)
    text = graph.read_text().replace(
        "{blobs: detect}", "{blobs: {from: detect, policy: drop_oldest, depth: 5}}"
    )
    graph.write_text(text.replace("{tracks: track}", "{tracks: {from: track, policy: latest}}"))
    plan = compile_graph(graph, plugin_files=[TOY])
    lines = show.text(plan).splitlines()
    assert "  detect.out      -> pair.blobs       reference, drop_oldest 5 × 2" in lines
    assert "  track.tracks    -> save.tracks      reference, latest" in lines
    assert "note: no source is live, so nothing is dropped: every edge blocks" in lines
    assert plan_from_data(plan_to_data(plan)).edges == plan.edges
    assert [edge.depth for edge in plan.edges if edge.drops] == [5, 5, 1]


def test_mermaid_holds_every_box_once_and_dots_what_is_delayed(plan: Plan) -> None:
    lines = show.mermaid(plan).splitlines()
    assert lines[0] == "flowchart LR"
    assert sum("subgraph" in line for line in lines) == 3
    assert sum("toy.detect" in line for line in lines) == 2
    assert sum("-.->" in line for line in lines) == 2
    assert sum(line.strip() == "end" for line in lines) == 3


def test_svg_is_a_picture_of_every_box_and_edge(plan: Plan) -> None:
    root = ET.fromstring(svg(plan))
    space = "{http://www.w3.org/2000/svg}"
    texts = {text.text for text in root.iter(f"{space}text")}
    assert {"worker left on pc-left", "worker main", "worker right", "pair", "reference", "zenoh"} <= set(
        texts
    )
    assert len(list(root.iter(f"{space}path"))) == 8
    width, height = float(root.attrib["width"]), float(root.attrib["height"])
    for box in root.iter(f"{space}rect"):
        right = float(box.attrib.get("x", 0)) + float(box.attrib["width"])
        bottom = float(box.attrib.get("y", 0)) + float(box.attrib["height"])
        assert right <= width
        assert bottom <= height


@pytest.mark.parametrize("placement", [None, "camera", "stage"])
@pytest.mark.parametrize("name", ["glowballs", "person_room"])
def test_no_line_of_the_picture_passes_behind_a_box_or_runs_along_another(
    name: str, placement: str | None
) -> None:
    found = compile_graph(GRAPHS / f"{name}.yaml", placement=placement)
    laid = layout(found, outline(found))
    lengths: dict[tuple[Point, Point], set[Hashable]] = defaultdict(set)
    for line, corners in laid.routes:
        assert len(corners) >= 4
        for start, end in pairwise(corners):
            assert start[0] == end[0] or start[1] == end[1]
            assert not [box for box, corner in laid.corner.items() if crosses(start, end, corner, laid)]
        for start, end in pairwise(corners[1:-1]):  # the first and last are of a port
            whose = (line.start, line.port) if line.back else (line.end, line.input)
            lengths[start, end].add((line.kind, whose))
    assert all(len(whose) == 1 for (start, end), whose in lengths.items() if start != end)


def crosses(start: Point, end: Point, corner: Point, laid: Layout) -> bool:
    """Whether a level or upright line has a part inside a box."""
    left, top = corner
    (x0, x1), (y0, y1) = sorted((start[0], end[0])), sorted((start[1], end[1]))
    return x0 < left + laid.box_width and x1 > left and y0 < top + HEIGHT and y1 > top
