"""A graph file takes the place of another in a plan that has travelled: no other file is read again."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from tests.core.graph.composed import TRACKER, after, by_name, planned, stage, travelled
from tests.core.graph.files import ROOM
from tests.core.graph.subgraph_files import EACH, SHARED, TWO, WING, WINGS, ZONED

from followspot.control.plan_transfer import packed
from followspot.errors import InputError
from followspot.graph.change.stages import change_of
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedWorker

GRAPHS = Path(__file__).parents[3] / "graphs"
AGAIN = TRACKER.replace("uses: toy.detect", "uses: toy.detect_again")


def levels(plan: Plan) -> dict[str, float]:
    return {one.name: one.params["level"] for one in plan.stages if "level" in one.params}


@pytest.mark.parametrize("main", [SHARED, EACH, TWO, WINGS])
def test_its_own_file_in_the_place_of_a_sub_graph_changes_nothing(tmp_path: Path, main: str) -> None:
    plan = travelled(planned(tmp_path, main, room=ZONED, wing=WING))
    for use in plan.subgraphs:
        file = "wing" if use.stage == "wing" else "tracker"
        for name in use.names:
            change = change_of(plan, [f"{name}={tmp_path / file}.yaml"])
            assert change.stages == ()
            assert by_name(change.subgraphs) == by_name(plan.subgraphs)


@pytest.mark.parametrize(
    ("graph", "files"),
    [("building", {"hall": "glowballs", "stage": "glowballs"}), ("show", {"balls": "glowballs"})],
)
def test_the_graphs_that_are_shipped_take_their_own_files_again(graph: str, files: dict[str, str]) -> None:
    plan = travelled(compile_graph(GRAPHS / f"{graph}.yaml"))
    assert files.keys() <= {use.stage for use in plan.subgraphs}
    for name, file in files.items():
        assert change_of(plan, [f"{name}={GRAPHS / file}.yaml"]).stages == ()


def test_only_the_new_file_is_read(tmp_path: Path) -> None:
    plan = travelled(planned(tmp_path, EACH, "tracker.level=0.25", room=ZONED, again=AGAIN))
    for name in ("main", "room", "tracker"):
        (tmp_path / f"{name}.yaml").unlink()
    one = after(plan, f"tracker/stage={tmp_path / 'again.yaml'}")
    assert {s.uses for s in one.stages if "/detect" in s.name} == {"toy.detect", "toy.detect_again"}
    assert levels(one) == levels(plan) == dict.fromkeys(levels(plan), 0.25), "what the graph gives stays"
    both = after(plan, f"tracker={tmp_path / 'again.yaml'}")
    assert {s.uses for s in both.stages if "/detect" in s.name} == {"toy.detect_again"}
    assert set(levels(after(both, "tracker.level=0.75")).values()) == {0.75}


def test_an_inner_and_an_outer_sub_graph_are_known_by_their_names(tmp_path: Path) -> None:
    plan = travelled(planned(tmp_path, WINGS, room=ZONED, wing=WING, again=AGAIN))
    inner = after(plan, f"wing/hall/inner={tmp_path / 'again.yaml'}")
    assert {s.name for s in inner.stages if s.uses == "toy.detect_again"} == {
        "wing/hall/inner/detect/cam0",
        "wing/hall/inner/detect/cam1",
    }
    assert set(levels(inner).values()) == {0.25}
    found = after(inner, "wing/hall.level=0.75", "wing/stage/inner.level=0.5")
    assert sorted(set(levels(found).values())) == [0.5, 0.75]
    back = after(inner, f"wing={tmp_path / 'wing.yaml'}")
    assert back.stages == plan.stages
    assert by_name(back.subgraphs) == by_name(plan.subgraphs)


def test_what_set_gave_is_known_after_a_journey(tmp_path: Path) -> None:
    room = ROOM + "tune: {toy.detect_again.level: 0.9}\n"
    start = planned(tmp_path, SHARED, "hall/detect.start=warm", room=room, again=AGAIN)
    plan = after(travelled(start), "hall/detect/cam1.level=0.75")
    swapped = after(plan, f"hall={tmp_path / 'again.yaml'}")
    assert levels(swapped) == {"hall/detect/cam0": 0.9, "hall/detect/cam1": 0.75}, "the room tunes the rest"
    if "start" in stage(swapped, "hall/detect/cam0").params:
        assert stage(swapped, "hall/detect/cam0").params["start"] == "warm"


def test_what_set_gave_a_sub_graph_wins_over_the_room_after_a_journey(tmp_path: Path) -> None:
    room = ROOM + "tune: {toy.detect_again.level: 0.9}\n"
    plan = travelled(planned(tmp_path, SHARED, "hall.level=0.25", room=room, again=AGAIN))
    assert set(levels(after(plan, f"hall={tmp_path / 'again.yaml'}")).values()) == {0.25}
    assert set(levels(after(plan, "hall/detect=toy.detect_again")).values()) == {0.25}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("tracks: track.tracks, ", ""), 'sub-graph "hall" has no output "tracks" in the file'),
        (("{blobs: detect}", "{blobs: [detect, detect]}"), "twice"),
        (("in: {blobs: pair}", "in: {blops: pair}"), 'has no input "blops"'),
        (("uses: toy.pair,", "uses: toy.gone,"), 'no stage "toy.gone" is installed'),
        (("{level: detect.level,", "{levle: detect.level,"), 'has no parameter "level"'),
        (("model: [track.model]", "model: [track.modle]"), 'has no parameter "modle"'),
        (("blobs: detect}\nstages", "blobs: nobody}\nstages"), 'the stage "nobody"'),
    ],
)
def test_a_file_that_does_not_fit_says_why(tmp_path: Path, change: tuple[str, str], said: str) -> None:
    main = SHARED.replace("frames: eyes}", "frames: eyes}, with: {level: 0.25}")
    assert change[0] in TRACKER
    other = TRACKER.replace(*change)
    plan = travelled(planned(tmp_path, main, other=other))
    with pytest.raises(InputError) as caught:
        change_of(plan, [f"hall={tmp_path / 'other.yaml'}"])
    assert said in str(caught.value)
    assert len(caught.value.mistakes) == 1


LATE_LEVEL = TRACKER.replace("level: detect.level", "level: late.level").replace(
    "  pair: {uses: toy.pair, in: {blobs: detect}}",
    "  late: {uses: toy.detect, each: cameras, in: {frame: camera}}\n"
    "  pair: {uses: toy.pair, in: {blobs: late}}",
)
"""Another stage is behind `level`."""
MOVED = (
    TRACKER.replace("detect:", "seen:").replace("detect.", "seen.").replace("blobs: detect}", "blobs: seen}")
)
NO_LEVEL = MOVED.replace("level: seen.level, ", "")


@pytest.mark.parametrize(
    "main", [SHARED, SHARED.replace("frames: eyes}", "frames: eyes}, with: {level: 0.25}")]
)
def test_what_set_gave_an_interface_reaches_a_file_with_another_stage_behind_it(
    tmp_path: Path, main: str
) -> None:
    room = ROOM + "tune: {late.level: 0.1, hall.level: 0.2}\n"
    plan = after(travelled(planned(tmp_path, main, room=room, late=LATE_LEVEL)), "hall.level=0.75")
    there = after(plan, f"hall={tmp_path / 'late.yaml'}")
    assert levels(there)["hall/late/cam0"] == levels(there)["hall/late/cam1"] == 0.75
    back = after(there, f"hall={tmp_path / 'tracker.yaml'}")
    assert set(levels(back).values()) == {0.75}
    assert by_name(back.subgraphs) == by_name(plan.subgraphs)


def test_a_file_without_what_was_set_takes_the_place_with_a_note(tmp_path: Path) -> None:
    plan = travelled(planned(tmp_path, SHARED, none=NO_LEVEL, late=LATE_LEVEL, moved=MOVED))
    plan = after(plan, "hall.level=0.75", "hall.model=quick", "hall/detect/cam1.start=warm")
    kept = after(plan, f"hall={tmp_path / 'late.yaml'}")
    assert not any("not taken over" in note for note in kept.notes), "detect stays, and has them"
    found = after(plan, f"hall={tmp_path / 'none.yaml'}")
    assert stage(found, "hall/track").params["model"] == "quick"
    assert {s.params["level"] for s in found.stages if "/seen" in s.name} == {0.5}
    assert [note for note in found.notes if "not taken over" in note] == [
        "while it ran: hall/detect/cam0: left (toy.detect); not taken over: level = 0.75",
        "while it ran: hall/detect/cam1: left (toy.detect); not taken over: level = 0.75, start = warm",
    ]
    moved = after(plan, f"hall={tmp_path / 'moved.yaml'}")
    assert [note for note in moved.notes if "not taken over" in note] == [
        "while it ran: hall/detect/cam1: left (toy.detect); not taken over: start = warm"
    ], "level is behind another stage now"


def test_no_value_of_a_parameter_is_in_what_every_host_gets(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED.replace("frames: eyes}", "frames: eyes}, with: {level: 0.3125}"))
    there = replace(plan, workers=tuple(PlannedWorker(w.name, "elsewhere") for w in plan.workers))
    data = packed(there, "pc-left", tmp_path)
    assert data["subgraphs"]
    assert "0.3125" not in json.dumps(data)
