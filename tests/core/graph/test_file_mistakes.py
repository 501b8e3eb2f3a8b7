"""Each mistake in files that use each other, overlays and options gives one error with its places."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import TRACKER, write
from tests.core.graph.files import ROOM, TOY
from tests.core.graph.wrong_compositions import Wrong, check, wrong

from followspot.errors import InputError
from followspot.graph.compile import compile_graph

ANY = "{uses: toy.any, in: {blobs: hall/inner/pair}}"
MISTAKES = {
    # files that use each other
    "recursion": wrong(
        "files use each other: middle.yaml -> tracker.yaml -> middle.yaml",
        "remove one use",
        ("tracker", "{uses: toy.any, in: {blobs: pair}}", "{graph: ¦middle.yaml}"),
        ("tracker", ", hint: extra.hint", ""),
        ("middle", ", hint: inner.hint", ""),
        ("tracker", "in: {blobs: extra}", "in: {blobs: pair}"),
        ("middle", "  inner:", "  ‡inner:"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "a graph that uses itself": wrong(
        "files use each other: main.yaml -> main.yaml",
        "remove one use",
        ("main", "graph: middle.yaml", "graph: ¦main.yaml"),
    ),
    "an overlay of itself": wrong(
        "files use each other: over.yaml -> over.yaml",
        "remove one use",
        over="extends: ¦over.yaml\n",
    ),
    "a base that uses its overlay": wrong(
        "files use each other: over.yaml -> main.yaml -> over.yaml",
        "remove one use",
        ("main", "graph: middle.yaml", "graph: ¦over.yaml"),
        over="extends: ‡main.yaml\n",
    ),
    "a file that is not there": wrong(
        "trackr.yaml: No such file or directory",
        "paths are relative to this file",
        ("middle", "tracker.yaml", "¦trackr.yaml"),
        ("main", "  hall:", "  ‡hall:"),
    ),
    "no file": wrong(
        "graph names a graph file, not 7", "graph: FILE.yaml", ("main", "graph: middle.yaml", "graph: ¦7")
    ),
    # keys and names
    "a stage that is a plugin and a graph": wrong(
        'sub-graph "hall" has no key "uses"',
        "keys: cameras, each, graph, in, optional, with",
        ("main", "{graph: middle.yaml", "{graph: middle.yaml, ¦uses: toy.any"),
    ),
    "a stage and a stage of a sub-graph of one name": wrong(
        'stage "hall/inner/pair" is declared twice',
        "rename one",
        ("main", "  save:", "  ¦hall/inner/pair: {uses: toy.any}\n  save:"),
        ("tracker", "  pair:", "  ‡pair:"),
    ),
    "an instance and a stage of a sub-graph of one name": wrong(
        '"hall/inner/detect/cam0" names an instance of stage "hall/inner/detect" and another stage',
        "rename one",
        ("main", "  save:", f"  ¦hall/inner/detect/cam0: {ANY}\n  save:"),
        ("tracker", "  detect:", "  ‡detect:"),
    ),
    "a name that is too long": wrong(
        "cannot be the name of a stage",
        "use 1 to 100 letters, digits",
        ("main", "  save:", f"  ¦{'/'.join(['part'] * 50)}: {ANY}\n  save:"),
    ),
    # overlays
    "an overlay that removes what is read": wrong(
        'stage "hall" is removed, but read by: save',
        "feed them from another stage, or remove them too",
        ("main", "tracks: hall.tracks", "tracks: ‡hall.tracks"),
        over="extends: main.yaml\nstages: {¦hall: null}\n",
    ),
    "an overlay that removes what an interface names": wrong(
        'stage "track" is removed, but read by: detect, params: model, outputs: tracks, outputs: forecast',
        "feed them from another stage",
        ("tracker", "{from: track.forecast, delay: 1}", "‡{from: track.forecast, delay: 1}"),
        over="extends: tracker.yaml\nstages: {¦track: null}\n",
    ),
    "an overlay that removes nothing": wrong(
        'there is no stage "hal" to remove',
        'did you mean "hall"?',
        over="extends: main.yaml\nstages: {¦hal: null}\n",
    ),
    "an overlay whose stage lacks an input": wrong(
        'stage "save" has no input "blobs"',
        "inputs: tracks",
        over="extends: main.yaml\nstages: {save: {in: {¦blobs: hall.tracks}}}\n",
    ),
    "an overlay of another type below": wrong(
        '"hall/inner/track.tracks" gives Tracks, but input "blobs" of stage "save" takes Blobs',
        "outputs of hall/inner/track",
        ("main", "toy.save, in: {tracks: hall.tracks}", "toy.pair, in: {blobs: ¦hall.tracks}"),
        ("middle", "tracks: inner.tracks", "tracks: ‡inner.tracks"),
        ("tracker", "tracks: track.tracks", "tracks: ‡track.tracks"),
        over="extends: ‡main.yaml\n",
    ),
    "a parameter that was lost with the old stage": wrong(
        'stage "track" (toy.track_again) needs the parameter "model"',
        "add with: {model: ...}",
        over="extends: tracker.yaml\nstages: {track: {uses: ¦toy.track_again}}\n",
    ),
    # options
    "an option for a stage that is not there": wrong(
        'the graph has no stage "hall/inner/detekt"',
        'did you mean "hall/inner/detect"?',
        option="¦hall/inner/detekt.level=1",
    ),
    "an option for an unknown parameter of an interface": wrong(
        'graph "middle", used as "hall", has no parameter "levle"',
        'did you mean "level"?',
        ("middle", "graph: middle", "‡graph: middle"),
        option="hall.¦levle=1",
    ),
    "an option for one member that is the same for all": wrong(
        '"hall/cam0" is one member of a sub-graph; cameras is the same for all',
        "write hall.cameras=...",
        ("main", "{graph: middle.yaml", "{each: cameras, graph: middle.yaml"),
        option="¦hall/cam0.cameras=targets",
    ),
    "an option for a replaced stage": wrong(
        'stage "hall/inner/camera" is replaced by an input',
        "set the stage that feeds this input",
        ("main", "frames: eyes", "frames: ‡eyes"),
        option="¦hall/inner/camera.frames=3",
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", MISTAKES.values(), ids=MISTAKES)
def test_a_mistake_in_files_or_options_is_one_error_with_all_places(tmp_path: Path, case: Wrong) -> None:
    check(tmp_path, case)


def test_files_that_unfold_without_end_are_refused_at_once(tmp_path: Path) -> None:
    """Each of 18 files uses the next one twice: a quarter of a million stages, if nothing stopped it."""
    files = {
        f"f{n}": f"stages: {{a: {{graph: f{n + 1}.yaml}}, b: {{graph: f{n + 1}.yaml}}}}\n" for n in range(18)
    }
    write(tmp_path, **files, f18="stages: {x: {uses: toy.knowing}}\n")
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "f0.yaml", plugin_files=[TOY])
    (mistake,) = caught.value.mistakes
    assert mistake.text == "more than 100 files, 1000 uses of files or 100000 values are used"


@pytest.mark.parametrize("key", ["extends: f{n}.yaml\n", "stages: {{a: {{graph: f{n}.yaml}}}}\n"])
def test_a_chain_of_files_has_a_limit(tmp_path: Path, key: str) -> None:
    write(tmp_path, **{f"f{n}": key.format(n=n + 1) for n in range(40)}, f40="stages: {}\n")
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "f0.yaml")
    (mistake,) = caught.value.mistakes
    assert mistake.text == "files use each other more than 20 levels deep"
    assert mistake.place is not None
    assert Path(mistake.place.file).name == "f19.yaml"


def test_many_files_with_many_values_have_a_limit(tmp_path: Path) -> None:
    value = "y" * 4000  # counts as 40 values
    large = "stages:\n" + "".join(f"  s{n}: {{with: {{x: {value}}}}}\n" for n in range(200))
    uses = "stages:\n" + "".join(f"  g{n}: {{graph: large.yaml}}\n" for n in range(90))
    write(tmp_path, main=uses, large=large)
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "main.yaml")
    (mistake,) = caught.value.mistakes
    assert "100000 values" in mistake.text


def test_an_input_of_two_stages_that_cannot_be_read_is_one_mistake(tmp_path: Path) -> None:
    both = TRACKER.replace("inputs: {", "inputs: {extra: [detect.forecast, pair.blobs], ")
    assert both != TRACKER
    text = "stages: {hall: {graph: tracker.yaml, in: {extra: [null]}}}\nroom: room.yaml\n"
    write(tmp_path, main=text, tracker=both, room=ROOM)
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "main.yaml", plugin_files=[TOY])
    (mistake,) = caught.value.mistakes
    assert mistake.text == "an input is fed from STAGE or STAGE.PORT, not nothing"


@pytest.mark.parametrize("content", ["\x01", "graph: a\n---\ngraph: b\n", "stages: [a]\n"])
def test_a_used_file_that_cannot_be_read_is_one_mistake_with_the_place_of_its_use(
    tmp_path: Path, content: str
) -> None:
    write(tmp_path, main="stages: {hall: {graph: used.yaml}}\n", used=content)
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "main.yaml")
    (mistake,) = caught.value.mistakes
    assert mistake.place is not None
    assert Path(mistake.place.file).name == "used.yaml"
    assert mistake.place.outer is not None
    assert Path(mistake.place.outer.file).name == "main.yaml"


@pytest.mark.parametrize("value", ["null", "[cam0, cam1]"])
def test_a_selector_that_cannot_be_read_is_named_by_its_key(tmp_path: Path, value: str) -> None:
    write(tmp_path, main=f"room: room.yaml\nstages: {{hall: {{graph: tracker.yaml, cameras: {value}}}}}\n")
    with pytest.raises(InputError) as caught:
        compile_graph(tmp_path / "main.yaml", plugin_files=[TOY])
    (mistake,) = caught.value.mistakes
    assert mistake.text.startswith("cameras cannot be ")
    assert mistake.help == 'write for example "cameras[kind=color]"'
