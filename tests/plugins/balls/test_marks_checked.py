"""A mark of no target is told before a run, where it is written."""

from __future__ import annotations

from pathlib import Path

import pytest

from followspot.errors import InputError
from followspot.graph.compile import compile_graph

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
