"""Marks of no target, and targets that need marks, are told before a run, where they are written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import followspot as fs
from followspot import room_file
from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.room import Target

GRAPHS = Path(__file__).parents[3] / "graphs"


@pytest.mark.parametrize("stage", ["balls.kalman", "balls.inertial"])
def test_a_mark_of_no_target_is_a_mistake_of_the_graph(tmp_path: Path, stage: str) -> None:
    graph = tmp_path / "graph.yaml"
    graph.write_text(
        f"graph: marked\nextends: {GRAPHS / 'glowballs.yaml'}\nstages:\n"
        f"  track:\n    uses: {stage}\n    with:\n      marks: {{red: [0, 0, 1], gren: [1, 0, 1]}}\n"
    )
    with pytest.raises(InputError) as caught:
        compile_graph(graph)
    (mistake,) = caught.value.mistakes
    assert mistake.text == 'marks: the room has no target "gren"'
    assert mistake.remedy.startswith('did you mean "green"?')
    assert mistake.place is not None
    assert (mistake.place.file, mistake.place.line, mistake.place.column) == (str(graph), 7, 14)


def test_marks_of_targets_are_fine() -> None:
    assert compile_graph(GRAPHS / "glowballs.yaml", overrides=["track.marks={red: [0, 0, 1]}"]).stages


@pytest.mark.parametrize(
    ("marked", "radii", "alike"),
    [
        (["red"], {}, "green, blue"),
        (["red", "blue"], {}, ""),
        ([], {"red": 0.1}, "green, blue"),
        (["green"], {"red": 0.1}, ""),
    ],
)
def test_targets_that_depth_cannot_tell_apart_are_warned_about(
    tmp_path: Path, marked: list[str], radii: dict[str, float], alike: str
) -> None:
    """Depth tells targets of different radii apart, and the last of a radius is found when all others are."""
    room = room_file.load(GRAPHS / "rooms/simulated_depth.yaml")
    targets = {name: Target(name, radii.get(name, 0.0762)) for name in room.targets}
    room_file.save(replace(room, targets=targets, tune={}), tmp_path / "room.yaml")
    marks = {name: [0.0, 0.0, 1.0] for name in marked}
    found = fs.check(GRAPHS / "depth.yaml", room=tmp_path / "room.yaml", set={"track.marks": marks})
    text = f"no camera sees colours, so nothing tells {alike} apart, and none is found"
    assert [mistake.text for mistake in found if mistake.warning] == ([text] if alike else [])


def test_a_run_whose_marks_are_wrong_says_what_helps(tmp_path: Path) -> None:
    marks = {"red": [0.0, 0.0, 1.0]}
    with fs.run(GRAPHS / "depth.yaml", set={"track.marks": marks}, out=tmp_path, frames=3) as run:
        (silence,) = run.wait().silences
    assert silence.stage == "gather"
    assert "track.marks" in silence.advice
