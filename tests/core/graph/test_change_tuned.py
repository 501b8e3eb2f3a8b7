"""What a change of a running plan takes from the room, and which interface of a sub-graph it knows."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import TRACKER, changed_stages, planned, stage, write
from tests.core.graph.files import ROOM, TOY
from tests.core.graph.subgraph_files import SHARED

from followspot.errors import InputError
from followspot.graph.change.stages import change_of
from followspot.graph.compile import compile_graph
from followspot.graph.plan import Plan
from followspot.operator.change_outcome import outcome_of_change, with_change

GRAPH = """\
graph: play
room: room.yaml
stages:
  camera: {uses: room.source, each: cameras}
  detect: {uses: toy.detect, each: cameras, in: {frame: camera}}
  pair: {uses: toy.pair, in: {blobs: detect}}
  track: {uses: toy.track, in: {blobs: pair}, with: {model: constant}}
"""


def tuned(folder: Path, tune: str, *overrides: str) -> Plan:
    write(folder, main=GRAPH, room=ROOM + f"tune: {tune}\n")
    return compile_graph(folder / "main.yaml", overrides=overrides, plugin_files=[TOY])


@pytest.mark.parametrize(
    ("tune", "overrides", "words", "found"),
    [
        ("{toy.track_again.gain: 5}", [], [], ("constant", 5.0)),
        ("{track.model: swift, toy.track_again.model: slow}", [], [], ("swift", 2.0)),
        ("{toy.track_again.model: swift}", [], [], ("swift", 2.0)),
        ("{toy.track_again.model: swift}", ["track.model=slow"], [], ("slow", 2.0)),
        ("{toy.track_again.model: swift}", [], ["track.model=free"], ("free", 2.0)),
        ("{toy.track_again.gain: 5}", [], ["track.gain=7"], ("constant", 7.0)),
        ("{toy.track.model: swift}", [], [], ("swift", 2.0)),
    ],
)
def test_a_new_stage_takes_what_the_room_tunes_of_it(
    tmp_path: Path, tune: str, overrides: list[str], words: list[str], found: tuple[str, float]
) -> None:
    plan = tuned(tmp_path, tune, *overrides)
    (track,) = changed_stages(plan, ["track=toy.track_again", *words])
    assert (track.params["model"], track.params["gain"]) == found


def test_what_was_set_while_it_ran_stays_and_the_rest_is_tuned(tmp_path: Path) -> None:
    plan = tuned(tmp_path, "{toy.track_again.model: swift, toy.track_again.gain: 5}")
    plan = with_change(plan, change_of(plan, ["track.model=free"]))
    plan = with_change(plan, change_of(plan, ["track=toy.track_again"]))
    assert stage(plan, "track").params == {"model": "free", "gain": 5.0}


def test_a_tune_of_one_camera_is_for_its_instance(tmp_path: Path) -> None:
    plan = tuned(tmp_path, "{toy.detect_again/cam1.level: 0.9}")
    found = {s.name: s.params["level"] for s in changed_stages(plan, ["detect=toy.detect_again"])}
    assert found == {"detect/cam0": 0.5, "detect/cam1": 0.9}


def test_the_change_and_the_plan_say_who_gave_each_value(tmp_path: Path) -> None:
    plan = tuned(tmp_path, "{toy.track_again.gain: 5}")
    found = change_of(plan, ["track=toy.track_again", "track.model=free"])
    (told,) = outcome_of_change("run", plan, found).stages
    place = f"{tmp_path / 'room.yaml'}:27 (tune of the room)"
    assert told.origins == {"gain": place}
    assert told.text == f"track: toy.track -> toy.track_again, model = free, gain = 5.0 from {place}"
    assert with_change(plan, found).notes[-1] == f"while it ran: {told.text}"


@pytest.mark.parametrize(
    ("tune", "said"),
    [
        ("{toy.track_again.gian: 5}", 'has no parameter "gian"'),
        ("{toy.track_again.gain: high}", '"gain" of stage "track" (toy.track_again) cannot be'),
        ("{toy.detect_again/cam0.level: 0.9, detect.level: 0.8}", 'tune one parameter of "detect/cam0"'),
    ],
)
def test_a_tune_that_does_not_fit_the_new_stage_is_a_mistake_of_the_room(
    tmp_path: Path, tune: str, said: str
) -> None:
    plan = tuned(tmp_path, tune)
    with pytest.raises(InputError) as caught:
        changed_stages(plan, ["detect=toy.detect_again" if "detect" in tune else "track=toy.track_again"])
    (mistake,) = caught.value.mistakes
    assert said in mistake.text
    assert mistake.place is not None
    assert mistake.place.file.endswith("room.yaml")


OTHER = TRACKER.replace("{level: detect.level,", "{brightness: detect.level,").replace(
    "toy.detect, each: cameras", "toy.detect, each: cameras, with: {level: 0.4}"
)


def swapped(folder: Path) -> Plan:
    """A plan whose sub-graph hall was replaced by other.yaml, which names its parameter in another way."""
    plan = planned(folder, SHARED, other=OTHER)
    plan = with_change(plan, change_of(plan, ["hall=other.yaml"], folder))
    assert stage(plan, "hall/detect/cam0").params["level"] == 0.4
    return plan


def test_after_a_swap_of_a_sub_graph_its_new_interface_holds(tmp_path: Path) -> None:
    plan = swapped(tmp_path)
    found = changed_stages(plan, ["hall.brightness=0.25"])
    assert {s.name: s.params["level"] for s in found} == {"hall/detect/cam0": 0.25, "hall/detect/cam1": 0.25}
    with pytest.raises(InputError, match="has no parameter"):
        changed_stages(plan, ["hall.level=0.25"])


def test_the_new_interface_holds_within_one_change_and_if_no_stage_differs(tmp_path: Path) -> None:
    plan = planned(
        tmp_path,
        SHARED,
        other=OTHER.replace("uses: toy.detect,", "uses: toy.detect_again,"),
        same=OTHER.replace("0.4", "0.5"),
    )
    found = changed_stages(plan, ["hall=other.yaml", "hall.brightness=0.25"], tmp_path)
    assert {(s.uses, s.params["level"]) for s in found} == {("toy.detect_again", 0.25)}
    found = change_of(plan, ["hall=same.yaml"], tmp_path)
    assert found.stages == ()
    assert changed_stages(with_change(plan, found), ["hall.brightness=0.25"])


def test_a_refused_swap_of_a_sub_graph_changes_nothing(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED, other="outputs: {tracks: t}\nstages: {t: {uses: toy.track}}\n")
    with pytest.raises(InputError):
        change_of(plan, ["hall=other.yaml"], tmp_path)
    assert changed_stages(plan, ["hall.level=0.25"])


def test_a_parameter_of_a_sub_graph_leaves_the_stages_that_were_swapped_in_it(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED)
    plan = with_change(plan, change_of(plan, ["hall/detect=toy.detect_again"]))
    found = changed_stages(plan, ["hall.level=0.25"])
    assert {(s.uses, s.params["level"]) for s in found} == {("toy.detect_again", 0.25)}


def test_a_swapped_sub_graph_takes_what_the_room_tunes_of_it(tmp_path: Path) -> None:
    room = ROOM + "tune: {toy.detect_again.level: 0.9}\n"
    other = TRACKER.replace("uses: toy.detect", "uses: toy.detect_again")
    plan = planned(tmp_path, SHARED, room=room, other=other)
    found = change_of(plan, ["hall=other.yaml"], tmp_path)
    (told, _) = outcome_of_change("run", plan, found).stages
    assert told.params["level"] == 0.9
    assert told.origins["level"].endswith(":27 (tune of the room)")
