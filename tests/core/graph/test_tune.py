"""The room tunes the graph: below `--set`, above what the graph says, the more specific tune first."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import planned
from tests.core.graph.files import ROOM, TOY, write

from followspot.cli.main import main
from followspot.errors import InputError
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.room_document.data import to_data
from followspot.room_file import load, save

GRAPH = """\
graph: tuned
room: room.yaml
stages:
  camera: {uses: room.source, each: cameras}
  detect: {uses: toy.detect, each: cameras, in: {frame: camera}, with: {level: 0.3, mood: {gain: 2.0}}}
  left/detect: {uses: toy.detect, each: cameras, in: {frame: camera}}
"""


def tuned(folder: Path, tune: str, *overrides: str) -> Plan:
    room = ROOM.replace("    host: pc-left\n", "") + f"tune: {tune}\n"
    graph = write(folder, graph=GRAPH, room=room)
    return compile_graph(graph, plugin_files=[TOY], overrides=overrides)


def levels(plan: Plan) -> list[float]:
    return [stage.params["level"] for stage in plan.stages if stage.uses == "toy.detect"]


@pytest.mark.parametrize(
    ("tune", "overrides", "found"),
    [
        ("{}", [], [0.3, 0.3, 0.5, 0.5]),
        ("{toy.detect.level: 0.9}", [], [0.9, 0.9, 0.9, 0.9]),
        ("{detect.level: 0.9}", [], [0.9, 0.9, 0.5, 0.5]),
        ("{left/detect.level: 0.9}", [], [0.3, 0.3, 0.9, 0.9]),
        ("{toy.detect/cam1.level: 0.9}", [], [0.3, 0.9, 0.5, 0.9]),
        ("{detect/cam0.level: 0.9, detect.level: 0.8, toy.detect.level: 0.7}", [], [0.9, 0.8, 0.7, 0.7]),
        ("{toy.detect.level: 0.7, detect.level: 0.8, detect/cam0.level: 0.9}", [], [0.9, 0.8, 0.7, 0.7]),
        ("{detect/cam0.level: 0.9}", ["detect.level=0.1"], [0.1, 0.1, 0.5, 0.5]),
        ("{toy.detect.level: 0.9}", ["detect.uses=toy.detect"], [0.9, 0.9, 0.9, 0.9]),
    ],
)
def test_precedence(tmp_path: Path, tune: str, overrides: list[str], found: list[float]) -> None:
    plan = tuned(tmp_path, tune, *overrides)
    assert levels(plan) == found
    assert plan.notes == ()


@pytest.mark.parametrize("given", ["", ", with: {lens: {gain: 2.0, bias: 2.0}}"])
@pytest.mark.parametrize(
    ("options", "found"),
    [
        ([], (5.0, 4.0)),
        (["lens.gain=7.0"], (7.0, 4.0)),
        (["lens.gain=7.0", "lens.bias=3.0"], (7.0, 3.0)),
        (["lens={gain: 7.0}"], (7.0, 0.0)),
        (["lens={}"], (1.0, 0.0)),
    ],
)
def test_set_within_a_tuned_value_keeps_its_place(
    tmp_path: Path, given: str, options: list[str], found: tuple[float, float]
) -> None:
    room = ROOM.replace("    host: pc-left\n", "") + "tune: {toy.through.lens: {gain: 5.0, bias: 4.0}}\n"
    stage = f"  look: {{uses: toy.through, each: cameras, in: {{frame: camera}}{given}}}\n"
    graph = write(tmp_path, graph=GRAPH + stage, room=room)
    plan = compile_graph(graph, plugin_files=[TOY], overrides=[f"look.{option}" for option in options])
    lenses = [planned.params["lens"] for planned in plan.stages if planned.group == "look"]
    assert lenses == [{"gain": found[0], "bias": found[1]}] * 2


def test_a_source_of_the_room_is_tuned_like_any_stage(tmp_path: Path) -> None:
    plan = tuned(tmp_path, "{toy.camera.frames: 3, camera/cam1.frames: 4}")
    assert [stage.params["frames"] for stage in plan.stages if stage.group == "camera"] == [3, 4]


def test_a_path_is_relative_to_the_room_file(tmp_path: Path) -> None:
    (tmp_path / "graphs").mkdir()
    room = ROOM.replace("    host: pc-left\n", "") + "tune: {toy.camera.path: truth.csv}\n"
    write(tmp_path, room=room)
    graph = tmp_path / "graphs/graph.yaml"
    graph.write_text(GRAPH.replace("room.yaml", "../room.yaml"), encoding="utf-8")
    plan = compile_graph(graph, plugin_files=[TOY])
    assert Path(plan.stages[0].params["path"]).resolve() == tmp_path / "truth.csv"


@pytest.mark.parametrize(
    ("tune", "guess"),
    [
        ("{detect/cam9.level: 0.9}", 'did you mean "detect/cam1"?'),
        ("{toy.detekt.level: 0.9}", 'did you mean "toy.detect"?'),
        ("{balls.color_blobs.similarity: 0.9}", ""),
        ("{zzz.level: 0.9}", ""),
    ],
)
def test_a_tune_that_matches_nothing_is_a_note(tmp_path: Path, tune: str, guess: str) -> None:
    (note,) = tuned(tmp_path, tune).notes
    assert note.startswith(f"{tmp_path / 'room.yaml'}:26: tune ")
    assert "matches nothing in this graph" in note
    assert note.endswith(guess)


@pytest.mark.parametrize(
    ("tune", "text"),
    [
        ("{toy.detect.levle: 0.9}", 'toy.detect has no parameter "levle"'),
        ("{detect/cam0.levle: 0.9}", 'toy.detect has no parameter "levle"'),
        ("{level: 0.9}", '"level" names no parameter'),
        ("{detect.level: 9}", "cannot be 9"),
        ("7", "tune is a mapping"),
        ("{zzz.level: {a: [1, .inf]}}", "tune holds inf"),
    ],
)
def test_a_wrong_tune_is_one_mistake_in_the_room_file(tmp_path: Path, tune: str, text: str) -> None:
    with pytest.raises(InputError) as caught:
        tuned(tmp_path, tune)
    (mistake,) = caught.value.mistakes
    assert text in mistake.text
    assert mistake.place is not None
    assert mistake.place.file.endswith("room.yaml")
    assert mistake.place.line == 26


def test_two_tunes_that_are_equally_specific_are_a_mistake_with_both_places(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        tuned(tmp_path, "{toy.detect/cam0.level: 0.9, detect.level: 0.8}")
    (mistake,) = caught.value.mistakes
    assert 'tune one parameter of "detect/cam0"' in mistake.text
    assert "detect/cam0.level" in mistake.remedy
    assert mistake.place is not None
    assert {mistake.place.column, mistake.place.outer_places[0].column} == {8, 36}
    plan = tuned(tmp_path, "{toy.detect/cam0.level: 0.9, detect.level: 0.8, detect/cam0.level: 0.7}")
    assert levels(plan) == [0.7, 0.8, 0.9, 0.5]


def test_tunes_are_written_back(tmp_path: Path) -> None:
    tuned(tmp_path, "{detect.level: 0.9, detect/cam0.mood: {gain: 3.0}, toy.detect.weights: [1.0, 2.0]}")
    room = load(tmp_path / "room.yaml")
    save(room, tmp_path / "again.yaml")
    again = to_data(load(tmp_path / "again.yaml"))
    assert again["tune"] == to_data(room)["tune"]
    assert again["tune"]["detect/cam0.mood"] == {"gain": 3.0}


def test_the_command_says_who_gave_each_parameter(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tuned(tmp_path, "{detect/cam0.level: 0.9, toy.camera.frames: 10}")
    graph = str(tmp_path / "graph.yaml")
    options = ["--parameters", "--plugin", TOY, "--set", "left/detect.start=warm"]
    assert main(["graph", graph, *options]) == 0
    rows = [line.split("  ") for line in capsys.readouterr().out.splitlines()]
    shown = [" ".join(part.strip() for part in row if part) for row in rows]
    room = tmp_path / "room.yaml"
    assert shown == [
        f"detect/cam0.level 0.9 (default 0.5) {room}:26 (tune of the room)",
        f'detect.mood {{"gain": 2.0}} (default {{"gain": 1.0}}) {graph}:5',
        f"detect/cam1.level 0.3 (default 0.5) {graph}:5",
        'left/detect.start "warm" (default "cold") --set',
    ]


TUNED = """\
graph: building
room: room.yaml
stages:
  hall: {graph: middle.yaml, WITH}
  side: {graph: tracker.yaml, each: cameras}
"""
MIDDLE = """\
graph: middle
params: {level: inner.level}
stages:
  inner: {graph: tracker.yaml}
"""


def of_subgraphs(folder: Path, tune: str, *overrides: str, given: str = "") -> Plan:
    """Levels of hall/inner/detect for two cameras, of side/cam0/detect and of side/cam1/detect."""
    room = ROOM.replace("    host: pc-left\n", "") + f"tune: {tune}\n"
    main = TUNED.replace(", WITH", f", with: {{{given}}}" if given else "")
    return planned(folder, main, *overrides, room=room, middle=MIDDLE)


@pytest.mark.parametrize(
    ("tune", "overrides", "found"),
    [
        ("{}", [], [0.3, 0.3, 0.5, 0.5]),
        ("{hall.level: 0.9}", [], [0.9, 0.9, 0.5, 0.5]),
        ("{side.level: 0.9}", [], [0.3, 0.3, 0.9, 0.9]),
        ("{side.level: 0.9, side/cam1.level: 0.8}", [], [0.3, 0.3, 0.9, 0.8]),
        ("{side/cam1.level: 0.8, side.level: 0.9}", [], [0.3, 0.3, 0.9, 0.8]),
        ("{hall.level: 0.9, hall/inner.level: 0.8}", [], [0.8, 0.8, 0.5, 0.5]),
        ("{hall.level: 0.9, hall/inner/detect.level: 0.8}", [], [0.8, 0.8, 0.5, 0.5]),
        ("{hall.level: 0.9, hall/inner/detect/cam1.level: 0.8}", [], [0.9, 0.8, 0.5, 0.5]),
        ("{hall.level: 0.9, toy.detect.level: 0.8}", [], [0.9, 0.9, 0.8, 0.8]),
        ("{hall.level: 0.9, toy.detect/cam0.level: 0.8}", [], [0.8, 0.9, 0.8, 0.5]),
        ("{hall.level: 0.9}", ["hall.level=0.1"], [0.1, 0.1, 0.5, 0.5]),
        ("{hall/inner.level: 0.9}", ["hall.level=0.1"], [0.1, 0.1, 0.5, 0.5]),
        ("{hall.level: 0.9}", ["hall/inner/detect.level=0.1"], [0.1, 0.1, 0.5, 0.5]),
        ("{side/cam1.level: 0.9}", ["side.level=0.1"], [0.3, 0.3, 0.1, 0.1]),
    ],
)
def test_parameters_of_sub_graphs_are_tuned(
    tmp_path: Path, tune: str, overrides: list[str], found: list[float]
) -> None:
    plan = of_subgraphs(tmp_path, tune, *overrides, given="level: 0.3")
    of = {s.name: s.params["level"] for s in plan.stages if s.uses == "toy.detect"}
    names = (
        "hall/inner/detect/cam0",
        "hall/inner/detect/cam1",
        "side/cam0/detect/cam0",
        "side/cam1/detect/cam1",
    )
    assert [of[name] for name in names] == found
    assert plan.notes == ()


@pytest.mark.parametrize(
    ("tune", "text"),
    [
        ("{hall.levle: 0.9}", 'graph "middle", used as "hall", has no parameter "levle"'),
        ("{hall.level: 9}", "cannot be 9"),
    ],
)
def test_a_wrong_tune_of_a_sub_graph_is_one_mistake_in_the_room_file(
    tmp_path: Path, tune: str, text: str
) -> None:
    with pytest.raises(InputError) as caught:
        of_subgraphs(tmp_path, tune)
    (mistake,) = caught.value.mistakes
    assert text in mistake.text
    assert mistake.place is not None
    assert (Path(mistake.place.file).name, mistake.place.line) == ("room.yaml", 26)


def test_a_tune_of_an_unknown_sub_graph_is_a_note_with_a_guess(tmp_path: Path) -> None:
    (note,) = of_subgraphs(tmp_path, "{hal.level: 0.9}").notes
    assert note.endswith('tune "hal.level" matches nothing in this graph; did you mean "hall"?')


def test_the_origin_of_a_tuned_parameter_of_a_sub_graph_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    of_subgraphs(tmp_path, "{hall.level: 0.9}")
    assert main(["graph", str(tmp_path / "main.yaml"), "--parameters", "--plugin", TOY]) == 0
    (row,) = (
        row for row in capsys.readouterr().out.splitlines() if row.startswith("hall/inner/detect.level")
    )
    assert f"{tmp_path / 'room.yaml'}:26 < " in row
    assert row.endswith("(tune of the room)")
