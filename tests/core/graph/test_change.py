"""What may become of a plan's stages while its run goes on, and what may not."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import TRACKER, changed_stages
from tests.core.graph.composed import planned as composed
from tests.core.graph.files import TOY, write

from followspot.errors import InputError
from followspot.graph.change.stages import with_stages
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan


@pytest.fixture
def plan(tmp_path: Path) -> Plan:
    return compile_graph(write(tmp_path), plugin_files=[TOY])


def test_a_parameter_is_set_in_all_instances_of_a_stage_or_in_one(plan: Plan) -> None:
    both = changed_stages(plan, ["detect.level=0.7"])
    assert {stage.name: stage.params["level"] for stage in both} == {"detect/cam0": 0.7, "detect/cam1": 0.7}
    (one,) = changed_stages(plan, ["detect/cam1.level=0.9", "detect/cam1.start=warm"])
    assert (one.name, one.params["level"], one.params["start"]) == ("detect/cam1", 0.9, "warm")
    assert one.params["weights"] == [1.0], "the others stay"


def test_a_stage_is_swapped_and_keeps_its_place_and_its_edges(plan: Plan) -> None:
    (pair,) = changed_stages(plan, ["pair=toy.pair_again"])
    old = next(stage for stage in plan.stages if stage.name == "pair")
    assert (pair.uses, pair.name, pair.worker) == ("toy.pair_again", "pair", old.worker)
    after = with_stages(plan, [pair])
    assert [stage.name for stage in after.stages] == [stage.name for stage in plan.stages]
    assert after.edges == plan.edges


def test_what_was_given_to_the_old_stage_is_given_to_the_new_one_where_it_has_that(plan: Plan) -> None:
    (track,) = changed_stages(plan, ["track=toy.track_again"])
    assert track.params == {"model": "constant", "gain": 2.0}
    (track,) = changed_stages(plan, ["track=toy.track_again", "track.gain=3"])
    assert track.params == {"model": "constant", "gain": 3.0}


def test_what_is_so_already_is_no_change(plan: Plan) -> None:
    assert changed_stages(plan, ["detect.level=0.5", "pair=toy.pair"]) == ()


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("detekt.level=0.7", 'no stage "detekt"'),
        ("detect.levle=0.7", 'did you mean "level"?'),
        ("detect.level=2", '"level" of stage "detect/cam0" (toy.detect) cannot be 2'),
        ("detect.mood.gain=2", "this cannot be changed"),
        ("detect.in.frame=camera", "this cannot be changed"),
        ("detect", "is no override"),
        ("pair=toy.nothing", 'no stage "toy.nothing" is installed'),
        ("pair=toy.split", '"pair.out" gives Blobs to others, its replacement does not'),
        ("pair=toy.any", "its replacement plain Blobs"),
        ("track=toy.save", 'has no input "blobs"'),
        ("save=toy.detect", 'needs the input "frame"'),
        ("camera.path=''", '"path" names no file: the path is empty'),
        ("camera.frames=5", 'source "camera/cam0" would begin its stream anew'),
        ("pair=toy.camera", "takes the place of a live source"),
        ("save=toy.save_again", 'would write tracks.csv, which "save" is writing'),
    ],
)
def test_what_does_not_fit_is_said(plan: Plan, word: str, said: str) -> None:
    with pytest.raises(InputError) as raised:
        changed_stages(plan, [word])
    assert said in str(raised.value)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["detect.level=0.7", "detect.level=0.8"], '"detect.level" is set to 0.7, and to 0.8'),
        (["pair=toy.pair_again", "pair=toy.pair"], '"pair.uses" is set to toy.pair_again, and to toy.pair'),
    ],
)
def test_words_that_undo_others_are_refused_with_both_values(plan: Plan, words: list[str], said: str) -> None:
    with pytest.raises(InputError) as raised:
        changed_stages(plan, words)
    assert said in str(raised.value)


@pytest.mark.parametrize(
    ("word", "typed"),
    [
        ("pair=toy.nothing", ("swap:1:1", "pair=toy.nothing", "^^^^")),
        ("pair=[", ("swap:1:7", "pair=[", "      ^")),
        ("detect.levle=0.7", ("set:1:8", "detect.levle=0.7", "       ^^^^^")),
        ("detect.level=2", ("set:1:14", "detect.level=2", "             ^")),
    ],
)
def test_a_mistake_points_at_what_was_typed(plan: Plan, word: str, typed: tuple[str, str, str]) -> None:
    with pytest.raises(InputError) as raised:
        changed_stages(plan, [word])
    place, text, caret = typed
    said, line, below = raised.value.mistakes[0].render().splitlines()[:3]
    assert said.startswith(f"{place}: ")
    assert line == f"    1 | {text}"
    assert below.startswith(f"      | {caret} ")


def test_paths_are_relative_to_the_folder_of_who_asks(plan: Plan, tmp_path: Path) -> None:
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "mask.png").write_text("")
    (stage,) = changed_stages(plan, ["pair=toy.masked", "pair.mask=mask.png"], tmp_path / "here")
    assert stage.params["mask"] == str(tmp_path / "here" / "mask.png")
    with pytest.raises(InputError, match="does not exist"):
        changed_stages(plan, ["pair=toy.masked", "pair.mask=mask.png"], tmp_path)


NOTHING = ("", "")
HALL = """\
graph: building
room: room.yaml
stages:
  hall: {graph: tracker.yaml, with: {level: 0.25}}
  save: {uses: toy.save, in: {tracks: hall.tracks}}
"""


def test_a_sub_graph_is_swapped_by_a_file_with_the_same_stages(tmp_path: Path) -> None:
    quick = TRACKER.replace("toy.pair,", "toy.pair_again,").replace("{model: constant}", "{model: quick}")
    plan = composed(tmp_path, HALL, quick=quick)
    changed = {stage.name: stage for stage in changed_stages(plan, ["hall=quick.yaml"], tmp_path)}
    assert changed.keys() == {"hall/pair", "hall/track"}
    assert changed["hall/pair"].uses == "toy.pair_again"
    assert changed["hall/track"].params == {"model": "quick"}
    after = with_stages(plan, changed.values())
    assert changed_stages(after, ["hall=quick.yaml"], tmp_path) == ()
    back = changed_stages(after, ["hall=tracker.yaml"], tmp_path)
    assert {stage.name for stage in back} == {"hall/pair", "hall/track"}


def test_a_parameter_of_an_interface_changes_the_stages_behind_it_alone(tmp_path: Path) -> None:
    plan = composed(tmp_path, HALL)
    plan = with_stages(plan, changed_stages(plan, ["hall/detect/cam0.start=warm"]))
    changed = changed_stages(plan, ["hall.level=0.5"])
    assert [(s.name, s.params["level"], s.params["start"]) for s in changed] == [
        ("hall/detect/cam0", 0.5, "warm"),
        ("hall/detect/cam1", 0.5, "cold"),
    ]


@pytest.mark.parametrize(
    ("word", "change", "text"),
    [
        ("hall=gone.yaml", NOTHING, "gone.yaml: No such file"),
        ("hall=quick.yaml", ("tracks: track.tracks", "track: track.tracks"), 'has no output "tracks"'),
        ("hall.levle=1", NOTHING, 'has no parameter "levle"'),
        ("hall.level=7", NOTHING, "cannot be 7"),
        ("hal=quick.yaml", NOTHING, 'the graph has no stage "hal"'),
    ],
)
def test_a_sub_graph_that_cannot_be_changed_says_why(
    tmp_path: Path, word: str, change: tuple[str, str], text: str
) -> None:
    plan = composed(tmp_path, HALL, quick=TRACKER.replace(*change) if change[0] else TRACKER)
    with pytest.raises(InputError) as caught:
        changed_stages(plan, [word], tmp_path)
    assert len(caught.value.mistakes) == 1
    assert text in str(caught.value)
