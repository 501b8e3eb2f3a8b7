"""Names of sub-graphs where stages are named: ports, placements, moves, pictures, completion."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import changed_stages, planned, write
from tests.core.graph.files import TOY
from tests.core.graph.subgraph_files import MIDDLE, NESTED, SHARED

from followspot.errors import InputError
from followspot.graph.change.move import plan_after_move
from followspot.graph.compile import compile_graph
from followspot.graph.drawing import text as show
from followspot.graph.drawing.svg import svg
from followspot.graph.names import subgraphs
from followspot.graph.output_ports import chosen_ports, output_ports


def test_a_word_names_the_ports_of_a_sub_graph_a_stage_or_an_instance(tmp_path: Path) -> None:
    ports = tuple(output_ports(planned(tmp_path, SHARED)))
    found = {word: chosen_ports(word, ports, "--ports") for word in ("hall", "hall/detect", "hall.tracks")}
    assert found["hall"] == tuple(port for port in ports if port.startswith("hall/"))
    assert found["hall/detect"] == ("hall/detect/cam0.out", "hall/detect/cam1.out")
    assert found["hall.tracks"] == ("hall/track.tracks",)
    with pytest.raises(InputError) as caught:
        chosen_ports("hall/detekt", ports, "--ports")
    assert 'did you mean "hall/detect"?' in caught.value.mistakes[0].remedy


def test_a_worker_takes_a_sub_graph_and_another_one_a_part_of_it(tmp_path: Path) -> None:
    write(tmp_path, main=NESTED, middle=MIDDLE)
    placement = tmp_path / "placement.yaml"
    placement.write_text(
        "workers:\n  a: {stages: [hall]}\n  b: {stages: [hall/inner/pair]}\n"
        "  c: {stages: [hall/inner/detect]}\n"
    )
    plan = compile_graph(tmp_path / "main.yaml", placement=placement, plugin_files=[TOY])
    assert {stage.name: stage.worker for stage in plan.stages} == {
        "eyes/cam0": "main",
        "eyes/cam1": "main",
        "hall/inner/detect/cam1": "c",
        "hall/inner/pair": "b",
        "hall/inner/extra": "a",
        "hall/inner/track": "a",
        "save": "main",
    }


def test_a_worker_for_each_stage_has_a_name_without_slashes(tmp_path: Path) -> None:
    write(tmp_path, main=SHARED)
    plan = compile_graph(tmp_path / "main.yaml", placement="stage", plugin_files=[TOY])
    assert "hall-detect" in {worker.name for worker in plan.workers}


def test_a_sub_graph_moves_as_a_whole(tmp_path: Path) -> None:
    live = SHARED.replace("room.source", "toy.device")
    write(tmp_path, main=live)
    placement = tmp_path / "placement.yaml"
    placement.write_text("workers: {a: {stages: [hall]}, b: {stages: [save]}}\n")
    plan = compile_graph(tmp_path / "main.yaml", placement=placement, plugin_files=[TOY])
    after = plan_after_move(plan, ["hall"], "b")
    assert {stage.worker for stage in after.stages if stage.name.startswith("hall/")} == {"b"}


def test_a_running_stage_of_a_sub_graph_changes_by_its_name(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED)
    (one,) = changed_stages(plan, ["hall/detect/cam0.level=0.25"])
    assert (one.name, one.params["level"]) == ("hall/detect/cam0", 0.25)
    assert len(changed_stages(plan, ["hall/detect.level=0.25"])) == 2


def test_sub_graphs_are_folded_in_pictures_unless_they_are_unfolded(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED)
    folded = show.text(plan).splitlines()
    assert "  hall  sub-graph, 4 stages  cam0 cam1" in folded
    assert "  eyes.out           -> hall/detect.frame  reference × 2" in folded
    assert "  hall/track.tracks  -> save.tracks        reference" in folded
    assert not any("hall/pair" in line for line in folded)
    assert "hall/pair" in show.text(plan, fold=False)
    assert "hall/pair" in svg(plan, fold=False)
    assert "hall/pair" not in svg(plan)
    assert "hall × 2" in svg(plan)
    assert "4 stages" in show.mermaid(plan)


def test_the_sub_graphs_of_a_stage_are_those_in_its_name() -> None:
    assert subgraphs("hall/left/color") == ["hall", "hall/left"]
    assert subgraphs("color") == []


def test_an_instance_and_a_stage_of_one_name_are_refused(tmp_path: Path) -> None:
    flat = "  eyes/cam0: {uses: toy.pair, in: {blobs: hall.blobs}}\n"
    with pytest.raises(InputError) as caught:
        planned(tmp_path, SHARED + flat)
    (mistake,) = caught.value.mistakes
    assert '"eyes/cam0" names an instance of stage "eyes" and another' in mistake.text
    assert mistake.place is not None
    assert (mistake.place.line, [place.line for place in mistake.place.outer_places]) == (7, [4])
