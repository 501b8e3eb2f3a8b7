"""From files to a plan: fan-out, ports, overrides, order, seeds."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.files import GRAPH, ROOM, TOY, write

from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan, PlannedStage

PAIR = "  pair: {uses: toy.pair, in: {blobs: detect}}\n"


def planned(folder: Path, *overrides: str, graph: str = GRAPH, room: str = ROOM) -> Plan:
    return compile_graph(write(folder, graph=graph, room=room), overrides=overrides, plugin_files=[TOY])


def stage(plan: Plan, name: str) -> PlannedStage:
    return next(stage for stage in plan.stages if stage.name == name)


def edges(plan: Plan) -> list[str]:
    return [edge.name + (f" delay {edge.delay}" if edge.delay else "") for edge in plan.edges]


def refused(folder: Path, *overrides: str, graph: str = GRAPH) -> list[str]:
    with pytest.raises(InputError) as caught:
        planned(folder, *overrides, graph=graph)
    return [mistake.render() for mistake in caught.value.mistakes]


def test_stages_fan_out_over_cameras_and_edges_over_instances(tmp_path: Path) -> None:
    plan = planned(tmp_path)
    assert [s.name for s in plan.stages] == [
        "camera/cam0",
        "camera/cam1",
        "detect/cam0",
        "detect/cam1",
        "pair",
        "track",
        "save",
    ]
    assert edges(plan) == [
        "camera/cam0.out -> detect/cam0.frame",
        "track.forecast -> detect/cam0.forecast delay 1",
        "camera/cam1.out -> detect/cam1.frame",
        "track.forecast -> detect/cam1.forecast delay 1",
        "detect/cam0.out -> pair.blobs",
        "detect/cam1.out -> pair.blobs",
        "pair.out -> track.blobs",
        "track.tracks -> save.tracks",
    ]
    assert [s.camera for s in plan.stages[:5]] == ["cam0", "cam1", "cam0", "cam1", None]


def test_a_camera_takes_its_source_from_the_room_and_the_graph_overrides_it(tmp_path: Path) -> None:
    plan = planned(tmp_path)
    assert [stage(plan, f"camera/cam{n}").params["frames"] for n in (0, 1)] == [20, 30]
    plan = planned(tmp_path, "camera.frames=5")
    assert [stage(plan, f"camera/cam{n}").params["frames"] for n in (0, 1)] == [5, 5]


def test_parameters_of_the_plan_are_complete_and_of_json_types(tmp_path: Path) -> None:
    plan = planned(tmp_path, "detect.weights=[1, 2]")
    assert stage(plan, "detect/cam0").params == {
        "level": 0.5,
        "start": "cold",
        "weights": [1.0, 2.0],
        "mood": {"gain": 1.0},
    }


def test_the_plan_does_not_depend_on_the_order_in_which_stages_are_declared(tmp_path: Path) -> None:
    head, _, body = GRAPH.partition("stages:\n")
    backwards = head + "stages:\n" + "\n".join(reversed(body.splitlines())) + "\n"
    order = [s.name for s in planned(tmp_path, graph=backwards).stages]
    assert order.index("camera/cam0") < order.index("detect/cam0") < order.index("pair")
    assert order.index("pair") < order.index("track") < order.index("save")


def test_a_latest_may_close_a_cycle_without_delay_in_a_live_run(tmp_path: Path) -> None:
    graph = GRAPH.replace("{from: track.forecast, delay: 1}", "track.forecast")
    plan = planned(tmp_path, graph=graph, room=ROOM.replace("toy.camera", "toy.device"))
    assert [s.group for s in plan.stages] == ["camera", "camera", "detect", "detect", "pair", "track", "save"]
    assert {edge.delay for edge in plan.edges} == {0}


def test_a_latest_outside_a_cycle_counts_for_the_order(tmp_path: Path) -> None:
    graph = GRAPH.replace("  camera:", "  hint: {uses: toy.any, in: {blobs: echo}}\n  camera:").replace(
        PAIR, PAIR + "  echo: {uses: toy.any, in: {blobs: pair, hint: track.forecast}}\n"
    )
    order = [s.name for s in planned(tmp_path, graph=graph).stages]
    assert order.index("track") < order.index("echo") < order.index("hint")


def test_a_stage_without_cameras_is_broadcast_to_those_with(tmp_path: Path) -> None:
    graph = GRAPH.replace(PAIR, PAIR + "  echo: {uses: toy.any, each: cameras, in: {blobs: pair}}\n")
    found = [name for name in edges(planned(tmp_path, graph=graph)) if "echo" in name]
    assert found == ["pair.out -> echo/cam0.blobs", "pair.out -> echo/cam1.blobs"]


def test_one_camera_may_feed_a_plain_input(tmp_path: Path) -> None:
    graph = GRAPH.replace("each: cameras", 'each: "cameras[kind=color]"').replace("toy.pair", "toy.any")
    assert "detect/cam0.out -> pair.blobs" in edges(planned(tmp_path, graph=graph))


def test_joined_edges_come_in_the_order_of_the_rooms_cameras(tmp_path: Path) -> None:
    second = '  second: {uses: toy.detect, each: "cameras[name=cam0]", in: {frame: camera}}\n'
    graph = GRAPH.replace(
        "detect: {uses: toy.detect, each: cameras", 'detect: {uses: toy.detect, each: "cameras[name=cam1]"'
    )
    graph = graph.replace(PAIR, second + PAIR.replace("detect", "[detect, second]"))
    joined = [name for name in edges(planned(tmp_path, graph=graph)) if "pair.blobs" in name]
    assert joined == ["second/cam0.out -> pair.blobs", "detect/cam1.out -> pair.blobs"]


@pytest.mark.parametrize(
    ("selector", "cameras"),
    [
        ("cameras", ["cam0", "cam1"]),
        ("cameras[]", ["cam0", "cam1"]),
        ("cameras[kind=infrared]", ["cam1"]),
        ("cameras[name = cam1|cam0]", ["cam0", "cam1"]),
        ("cameras[kind=color, name=cam0]", ["cam0"]),
        ("cameras[host=pc-left]", ["cam1"]),
        ("cameras[model=pinhole]", ["cam0", "cam1"]),
    ],
)
def test_selectors_choose_cameras_in_the_order_of_the_room(
    tmp_path: Path, selector: str, cameras: list[str]
) -> None:
    plan = planned(tmp_path, f"detect.each={selector!r}")
    assert [s.camera for s in plan.stages if s.group == "detect"] == cameras


def test_any_part_of_a_graph_can_be_overridden(tmp_path: Path) -> None:
    split = "  split: {uses: toy.split, each: cameras, in: {blobs: detect}}\n"
    plan = planned(
        tmp_path,
        "pair.uses=toy.any",
        "pair.in.blobs=[split.left]",
        "detect.level=0.25",
        "detect.mood.gain=3",
        "track.with.model=steady",
        "track.on_error=skip",
        "track.tolerance=0.01",
        "track.deadline=2",
        "save.in.tracks={from: track, depth: 3}",
        graph=GRAPH.replace(PAIR, PAIR + split).replace("each: cameras", 'each: "cameras[kind=color]"'),
    )
    assert stage(plan, "pair").uses == "toy.any"
    assert "split/cam0.left -> pair.blobs" in edges(plan)
    assert stage(plan, "detect/cam0").params["level"] == 0.25
    assert stage(plan, "detect/cam0").params["mood"] == {"gain": 3.0}
    track = stage(plan, "track")
    assert track.params == {"model": "steady"}
    assert (track.on_error, track.tolerance, track.deadline) == ("skip", 0.01, 2.0)
    assert plan.edges[-1].depth == 3


@pytest.mark.parametrize(
    ("option", "column", "said"),
    [
        ("detect.level=2", 14, "must be less than or equal to 1"),
        ("detect.levle=1", 8, 'has no parameter "levle"'),
        ("detekt.level=1", 1, 'the graph has no stage "detekt"'),
        ("detect.uses=toy.detekt", 13, 'no stage "toy.detekt" is installed'),
        ("detect.level=[1", 16, "not valid YAML"),
        ("detect.in=camera", 8, '"in" holds several values'),
        ("detect.in.frame=track", 17, "has no output of type Frame"),
        ("detect.in.frme=camera", 11, 'has no input "frme"'),
        ("detect", 1, "is no override"),
        ("level=2", 1, "is no override"),
        ("detect.=2", 1, "is no override"),
        ("", 1, "is no override"),
        ("camera.path=nowhere.png", 13, "which does not exist"),
    ],
)
def test_a_mistake_in_an_override_is_shown_in_its_text(
    tmp_path: Path, option: str, column: int, said: str
) -> None:
    shown = refused(tmp_path, option)[0]
    assert shown.startswith(f"--set:1:{column}: ")
    assert said in shown
    if option:
        line, caret = shown.splitlines()[1:3]
        assert line == f"    1 | {option}"
        assert caret.index("^") == len("    1 | ") + column - 1


def test_the_seed_comes_from_the_option_or_the_graph_or_is_nought(tmp_path: Path) -> None:
    graph = write(tmp_path)
    assert compile_graph(graph, plugin_files=[TOY]).seed == 7
    assert compile_graph(graph, plugin_files=[TOY], seed=3).seed == 3
    assert planned(tmp_path, graph=GRAPH.replace("seed: 7\n", "")).seed == 0


def test_another_room_serves_the_same_graph(tmp_path: Path) -> None:
    graph = write(tmp_path)
    (tmp_path / "small.yaml").write_text(ROOM.partition("  cam1:")[0])
    plan = compile_graph(graph, room=tmp_path / "small.yaml", plugin_files=[TOY])
    assert [s.name for s in plan.stages][:2] == ["camera/cam0", "detect/cam0"]
    with pytest.raises(InputError, match=r"--room:1:1: cannot read gone\.yaml"):
        compile_graph(graph, room="gone.yaml", plugin_files=[TOY])


def test_input_paths_become_absolute_from_the_file_they_stand_in(tmp_path: Path) -> None:
    (tmp_path / "rooms").mkdir()
    (tmp_path / "rooms" / "clip.png").touch()
    (tmp_path / "rooms" / "truth.csv").touch()
    room = ROOM.replace("{frames: 20}", "{path: clip.png}")
    graph = write(tmp_path)
    (tmp_path / "rooms" / "room.yaml").write_text(room)
    plan = compile_graph(graph, room=tmp_path / "rooms" / "room.yaml", plugin_files=[TOY])
    assert stage(plan, "camera/cam0").params["path"] == str(tmp_path / "rooms" / "clip.png")
    assert plan.room.truth is not None
    assert plan.room.truth.params == {"path": str(tmp_path / "rooms" / "truth.csv")}


def test_a_graph_may_do_without_a_room(tmp_path: Path) -> None:
    text = "stages:\n  know: {uses: toy.knowing, with: {path: truth.csv}}\n"
    plan = compile_graph(write(tmp_path, graph=text), plugin_files=[TOY])
    assert (plan.graph, plan.room.name, len(plan.stages)) == ("graph", "room", 1)
    (found,) = refused(tmp_path, graph="stages:\n  eye: {uses: toy.camera, each: cameras}\n")
    assert "needs cameras, but the graph names no room" in found


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "a graph is a mapping of keys to values, not nothing"),
        ("graph: nothing\n", "the graph has no stages"),
        ("stages: {}\n", "the graph has no stages"),
        ("stages: [a, b]\n", "stages is a mapping of names to values, not a list"),
    ],
)
def test_an_empty_graph_is_one_mistake(tmp_path: Path, text: str, said: str) -> None:
    (mistake,) = refused(tmp_path, graph=text)
    assert said in mistake


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["detect.level=0.1", "detect.level=0.2"], '"detect.level" is set to 0.1, and to 0.2'),
        (["pair.uses=toy.any", "pair.uses=toy.pair"], '"pair.uses" is set to toy.any, and to toy.pair'),
        (
            ["detect.with.level=0.1", "detect.level=0.2"],
            '"detect.with.level" is set to 0.1, and "detect.level" to 0.2',
        ),
        (
            ["pair.in.blobs.from=a", "pair.in.blobs=detect"],
            '"pair.in.blobs.from" is set to a, and "pair.in.blobs" to detect',
        ),
    ],
)
def test_options_that_undo_others_are_refused_with_both_values(
    tmp_path: Path, options: list[str], said: str
) -> None:
    assert any(said in mistake for mistake in refused(tmp_path, *options))


def test_options_that_say_the_same_twice_or_a_part_of_the_other_are_no_mistake(tmp_path: Path) -> None:
    plan = planned(tmp_path, "detect.level=0.1", "detect.with.level=0.1")
    assert {stage.params["level"] for stage in plan.stages if stage.group == "detect"} == {0.1}


def test_mistakes_of_graph_room_placement_and_options_are_reported_together(tmp_path: Path) -> None:
    graph = write(
        tmp_path,
        graph=GRAPH.replace("toy.pair", "toy.peir").replace("constant", "7"),
        room=ROOM.replace("kind: color", "kind: a b"),
        placement="by: planet\n",
    )
    with pytest.raises(InputError) as caught:
        compile_graph(
            graph,
            placement=tmp_path / "placement.yaml",
            overrides=["nobody.x=1"],
            plugin_files=[TOY, str(tmp_path / "none.py")],
        )
    shown = str(caught.value)
    for part in (
        "none.py cannot be read: No such file",
        "--set:1:1",
        "toy.peir",
        "cannot be 7",
        'cannot be "a b"',
    ):
        assert part in shown


def test_stages_that_a_refused_plugin_file_may_offer_are_no_mistakes_of_their_own(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("import no_such_package\n")
    graph = write(tmp_path, graph="graph: g\nstages: {a: {uses: mine.own}, b: {uses: toy.peir}}\n")
    with pytest.raises(InputError) as caught:
        compile_graph(graph, plugin_files=[TOY, str(tmp_path / "mine.py")])
    (refused_file, like_another) = caught.value.mistakes
    assert "No module named 'no_such_package'" in refused_file.text
    assert like_another.text == 'no stage "toy.peir" is installed'


def test_a_mistake_of_a_stage_is_reported_once_however_many_cameras(tmp_path: Path) -> None:
    assert len(refused(tmp_path, "detect.level=7")) == 1
