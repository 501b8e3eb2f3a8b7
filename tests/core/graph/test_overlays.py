"""`extends`: a file that says only what differs from another one."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import edges, names, planned, stage, write
from tests.core.graph.files import ROOM, TOY

from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.graph.plan_data import plan_to_data

BARE = "extends: graph.yaml\n"


def refused(folder: Path, main: str, **files: str) -> list[str]:
    with pytest.raises(InputError) as caught:
        planned(folder, main, **files)
    return [mistake.render() for mistake in caught.value.mistakes]


def test_an_overlay_that_changes_nothing_is_the_same_graph(tmp_path: Path) -> None:
    plan = planned(tmp_path, BARE)
    base = compile_graph(tmp_path / "graph.yaml", plugin_files=[TOY])
    assert plan_to_data(plan) == plan_to_data(base)


def test_parameters_and_inputs_merge_by_key_and_the_rest_is_replaced(tmp_path: Path) -> None:
    text = """\
graph: other
extends: graph.yaml
seed: 9
stages:
  detect: {with: {level: 0.25}, in: {forecast: {from: track.forecast, delay: 3}}}
  track: {uses: toy.track, with: {model: fast}, on_error: skip}
  more: {uses: toy.save, in: {tracks: track}, with: {path: more.csv}}
"""
    plan = planned(tmp_path, text)
    assert (plan.graph, plan.seed, plan.room.name) == ("other", 9, "stage")
    assert names(plan)[-2:] == ["save", "more"]
    assert stage(plan, "detect/cam0").params["level"] == 0.25
    assert "camera/cam0.out -> detect/cam0.frame" in edges(plan)
    assert "track.forecast -> detect/cam0.forecast delay 3" in edges(plan)
    assert (stage(plan, "track").params, stage(plan, "track").on_error) == ({"model": "fast"}, "skip")


def test_a_changed_stage_loses_its_parameters_and_an_unchanged_one_keeps_them(tmp_path: Path) -> None:
    kept = planned(tmp_path, BARE + "stages: {track: {uses: toy.track}}\n")
    assert stage(kept, "track").params == {"model": "constant"}
    (lost,) = refused(tmp_path, BARE + "stages: {track: {uses: toy.track_again}}\n")
    assert 'needs the parameter "model"' in lost
    assert lost.startswith(f"{tmp_path / 'main.yaml'}:2:24: ")


def test_null_removes_a_stage_an_input_and_a_key(tmp_path: Path) -> None:
    text = BARE + "stages: {pair: null, detect: {in: {forecast: null}}, track: {in: {blobs: pick}},"
    text += " save: {with: null},"
    text += " pick: {uses: toy.any, in: {blobs: detect}}}\nroom: one.yaml\noutputs: {tracks: null}\n"
    one = ROOM.split("  cam1:")[0] + "truth: {uses: toy.knowing, with: {path: truth.csv}}\n"
    plan = planned(tmp_path, text, one=one)
    assert names(plan) == ["camera/cam0", "detect/cam0", "pick", "track", "save"]
    assert edges(plan) == [
        "camera/cam0.out -> detect/cam0.frame",
        "pick.out -> track.blobs",
        "track.tracks -> save.tracks",
        "detect/cam0.out -> pick.blobs",
    ]


def test_several_levels_of_overlays_apply_in_their_order(tmp_path: Path) -> None:
    (tmp_path / "below").mkdir()
    middle = "graph: middle\nextends: ../graph.yaml\nstages: {save: null, track: {with: {model: middle}}}\n"
    (tmp_path / "below" / "middle.yaml").write_text(middle)
    top = "extends: below/middle.yaml\nstages: {save: {uses: toy.save_again, in: {tracks: track}}}\n"
    plan = planned(tmp_path, top)
    assert (plan.graph, stage(plan, "track").params["model"]) == ("middle", "middle")
    assert (stage(plan, "save").uses, plan.room.name) == ("toy.save_again", "stage")


def test_paths_stay_relative_to_the_file_that_they_stand_in(tmp_path: Path) -> None:
    write(tmp_path)
    (tmp_path / "below").mkdir()
    (tmp_path / "below" / "mask.png").write_text("")
    (tmp_path / "below" / "base.yaml").write_text(
        "extends: ../graph.yaml\nstages: {pair: {uses: toy.masked, with: {mask: mask.png}}}\n"
    )
    plan = planned(tmp_path, "extends: below/base.yaml\nstages: {pair: {on_error: skip}}\n")
    assert stage(plan, "pair").params == {"mask": str(tmp_path / "below" / "mask.png")}


def test_a_mistake_in_the_base_names_the_overlay_too(tmp_path: Path) -> None:
    base = "extends: graph.yaml\nstages: {pair: {with: {gain: 2}}}\n"
    (found,) = refused(tmp_path, "extends: base.yaml\n", base=base)
    assert found.startswith(f"{tmp_path / 'base.yaml'}:2:24: ")
    assert f"\n  see {tmp_path / 'main.yaml'}:1:10\n    1 | extends: base.yaml\n" in found


def test_options_apply_after_overlays(tmp_path: Path) -> None:
    plan = planned(tmp_path, BARE + "stages: {track: {with: {model: slow}}}\n", "track.model=fast")
    assert stage(plan, "track").params["model"] == "fast"


def test_null_is_a_value_of_a_parameter(tmp_path: Path) -> None:
    (found,) = refused(tmp_path, BARE + "stages: {track: {with: {model: null}}}\n")
    assert '"model" of stage "track" (toy.track) cannot be' in found


def test_a_removed_stage_may_come_back_in_the_next_overlay(tmp_path: Path) -> None:
    base = "extends: graph.yaml\nstages: {pair: null}\n"
    top = "extends: base.yaml\nstages: {pair: {uses: toy.pair_again, in: {blobs: detect}}}\n"
    assert stage(planned(tmp_path, top, base=base), "pair").uses == "toy.pair_again"
