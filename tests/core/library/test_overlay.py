"""What was changed in a run is saved as a file that extends its graph and runs the same."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from followspot.errors import FollowspotError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.library.overlay import save_overlay
from followspot.operator.run_requests import RunMetadata

ROOT = Path(__file__).parents[3]
GRAPH = ROOT / "graphs" / "glowballs.yaml"


class Run:
    """A run whose plan is the one of a graph with these changes."""

    def __init__(self, graph: Path, *changes: str, **options: Any) -> None:
        self.present: Plan = compile_graph(graph, overrides=changes, **options)

    def plan(self) -> Plan:
        return self.present

    def metadata(self) -> RunMetadata:
        return RunMetadata(source_files=self.present.source_files)


def save(run: Run, path: Path) -> tuple[str, ...]:
    return save_overlay(run, path)  # type: ignore[arg-type]


def stages(plan: Plan) -> dict[str, tuple[str, Any]]:
    return {stage.name: (stage.uses, dict(stage.params)) for stage in plan.stages}


def test_the_saved_file_gives_the_stages_of_the_run_and_says_nothing_else(tmp_path: Path) -> None:
    before = GRAPH.read_bytes()
    run = Run(GRAPH, "color.similarity=0.85", "fuse.uses=balls.mean", "track.minimum_support=5")
    assert save(run, tmp_path / "show.yaml") == ("fuse", "color", "track")
    assert stages(compile_graph(tmp_path / "show.yaml")) == stages(run.present)
    head, name, extends, *rest = (tmp_path / "show.yaml").read_text().splitlines()
    assert head.startswith("# Saved from a run of glowballs, ")
    assert name == "graph: show"
    assert extends.endswith('graphs/glowballs.yaml"')
    assert rest == [
        "stages:",
        '  fuse: {"uses": "balls.mean"}',
        '  color: {"with": {"similarity": 0.85}}',
        '  track: {"with": {"minimum_support": 5}}',
    ]
    assert GRAPH.read_bytes() == before
    assert [path.name for path in tmp_path.iterdir()] == ["show.yaml"]


def test_parameters_of_a_stage_that_was_swapped_in_are_saved(tmp_path: Path) -> None:
    run = Run(GRAPH, "fuse.uses=balls.bundle", "fuse.contradiction_exponent=0.5")
    save(run, tmp_path / "show.yaml")
    assert stages(compile_graph(tmp_path / "show.yaml")) == stages(run.present)


def test_the_room_that_was_named_is_named_in_the_file(tmp_path: Path) -> None:
    room = ROOT / "graphs" / "rooms" / "simulated_bright.yaml"
    run = Run(GRAPH, "color.similarity=0.93", room=room)
    save(run, tmp_path / "show.yaml")
    saved = compile_graph(tmp_path / "show.yaml")
    assert saved.room.name == run.present.room.name == "simulated_bright"
    assert stages(saved) == stages(run.present)


def test_the_seed_that_was_given_is_in_the_file(tmp_path: Path) -> None:
    run = Run(GRAPH, seed=5)
    assert save(run, tmp_path / "show.yaml") == ("seed",)
    assert compile_graph(tmp_path / "show.yaml").seed == 5


def test_texts_and_folders_of_any_script_are_saved(tmp_path: Path) -> None:
    folder = tmp_path / "größe \U0001f388"
    folder.mkdir()
    graph = folder / "odd.yaml"
    graph.write_text(
        f"graph: odd\nextends: {GRAPH}\nstages:\n  patch: {{uses: sinks.osc, in: {{tracks: track}}}}\n"
    )
    run = Run(graph, 'patch.prefix="/\U00020bb7é"')
    save(run, tmp_path / "show.yaml")
    assert stages(compile_graph(tmp_path / "show.yaml")) == stages(run.present)


def test_an_overlay_is_saved_as_an_overlay_of_it(tmp_path: Path) -> None:
    first = tmp_path / "first.yaml"
    save(Run(GRAPH, "color.similarity=0.85"), first)
    text = first.read_bytes()
    run = Run(first, "color.minimum_area=0.5")
    save(run, tmp_path / "second.yaml")
    assert first.read_bytes() == text
    assert stages(compile_graph(tmp_path / "second.yaml")) == stages(run.present)


def test_a_file_that_exists_is_left_as_it_is(tmp_path: Path) -> None:
    (tmp_path / "show.yaml").write_text("mine")
    with pytest.raises(FollowspotError, match=r"is there already\n    name another file"):
        save(Run(GRAPH, "color.similarity=0.85"), tmp_path / "show.yaml")
    assert (tmp_path / "show.yaml").read_text() == "mine"


@pytest.mark.parametrize(
    ("changes", "path", "message"),
    [
        ((), "show.yaml", "nothing differs"),
        (("color.similarity=0.85",), "show.txt", "write NAME.yaml"),
        (("color.similarity=0.85",), "nowhere/show.yaml", "nowhere cannot be written"),
    ],
)
def test_what_cannot_be_saved_is_told(
    tmp_path: Path, changes: tuple[str, ...], path: str, message: str
) -> None:
    with pytest.raises(FollowspotError, match=message):
        save(Run(GRAPH, *changes), tmp_path / path)
    assert not list(tmp_path.iterdir())


def test_a_stage_within_a_sub_graph_is_named(tmp_path: Path) -> None:
    graph = tmp_path / "hall.yaml"
    graph.write_text(
        f"graph: hall\nroom: {ROOT}/graphs/rooms/simulated.yaml\nstages:\n  hall: {{graph: {GRAPH}}}\n"
    )
    with pytest.raises(FollowspotError, match="hall/color is in a sub-graph"):
        save(Run(graph, "hall/color.similarity=0.85"), tmp_path / "show.yaml")


def test_a_run_without_a_file_has_nothing_to_extend(tmp_path: Path) -> None:
    run = Run(GRAPH, "color.similarity=0.85")
    run.metadata = RunMetadata  # type: ignore[method-assign, assignment]
    with pytest.raises(FollowspotError, match="nothing to extend"):
        save(run, tmp_path / "show.yaml")


def test_a_file_whose_edges_were_changed_since_the_run_began_is_no_base(tmp_path: Path) -> None:
    graph = tmp_path / "g.yaml"
    graph.write_text(GRAPH.read_text().replace("rooms/", f"{GRAPH.parent}/rooms/"))
    for changes in ((), ("color.similarity=0.85",)):
        run = Run(graph, *changes)
        before = graph.read_text()
        graph.write_text(before.replace("delay: 1", "delay: 2", 1))
        why = r"track.forecast -> color/cam0.forecast, .*: not in g.yaml as in this run; was a file changed"
        with pytest.raises(FollowspotError, match=why):
            save(run, tmp_path / "show.yaml")
        graph.write_text(before)
        assert not (tmp_path / "show.yaml").exists()
