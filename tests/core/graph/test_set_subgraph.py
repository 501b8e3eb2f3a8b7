"""Parameters of a sub-graph that are set while the graph runs; what cannot be set is refused."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.core.graph.composed import TRACKER, planned, write
from tests.core.graph.subgraph_files import EACH, SHARED, ZONED

from followspot.errors import InputError
from followspot.graph.change.stages import change_of
from followspot.graph.plan import Plan
from followspot.operator.change_outcome import with_change


def after(plan: Plan, *words: str) -> Plan:
    return with_change(plan, change_of(plan, words))


def levels(plan: Plan) -> dict[str, float]:
    return {stage.name: stage.params["level"] for stage in plan.stages if "level" in stage.params}


def test_a_parameter_can_be_set_back_to_what_it_was(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED, "hall.level=0.25")
    changed = after(plan, "hall.level=0.75")
    assert set(levels(changed).values()) == {0.75}
    assert levels(after(changed, "hall.level=0.25")) == levels(plan)


def test_a_member_of_a_fan_out_can_be_set_back_alone(tmp_path: Path) -> None:
    plan = planned(tmp_path, EACH, room=ZONED)
    changed = after(plan, "tracker.level=0.75")
    back = levels(after(changed, "tracker/stage.level=0.5"))
    assert {name for name, level in back.items() if level == 0.5} == {"tracker/stage/detect/cam1"}
    assert set(back.values()) == {0.5, 0.75}


def test_a_value_that_suits_none_of_several_stages_is_one_mistake(tmp_path: Path) -> None:
    plan = planned(tmp_path, EACH, room=ZONED)
    with pytest.raises(InputError) as caught:
        change_of(plan, ["tracker.level=high"])
    (mistake,) = caught.value.mistakes
    assert mistake.text.startswith('"level" of stage "tracker/hall/detect/cam0" (toy.detect) cannot be')


SOFTER = TRACKER.replace("graph: tracker", "graph: softer")


@pytest.mark.parametrize("word", ["hall.level=0.75", "hall/detect/cam1.level=0.75"])
def test_what_was_set_stays_when_a_sub_graph_is_replaced(tmp_path: Path, word: str) -> None:
    plan = planned(tmp_path, SHARED)
    before = after(plan, word)
    write(tmp_path, softer=SOFTER.replace("uses: toy.detect", "uses: toy.detect_again"))
    swapped = after(before, f"hall={tmp_path / 'softer.yaml'}")
    assert swapped.notes != before.notes
    assert levels(swapped) == levels(before) != levels(plan)
    again = after(swapped, f"hall={tmp_path / 'softer.yaml'}")
    assert levels(again) == levels(before), "it counts as set after a change, too"


def test_what_was_set_is_forgotten_with_its_parameter(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED)
    write(tmp_path, softer=SOFTER)
    plan = after(plan, "hall.level=0.75")
    other = after(plan, "hall/detect=toy.through")
    assert not levels(other)
    assert set(levels(after(other, f"hall={tmp_path / 'softer.yaml'}")).values()) == {0.5}


def test_a_file_and_its_parameter_may_come_in_any_order(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED)
    write(tmp_path, softer=SOFTER)
    file = f"hall={tmp_path / 'softer.yaml'}"
    assert levels(after(plan, "hall.level=0.75", file)) == levels(after(plan, file, "hall.level=0.75"))


@pytest.mark.parametrize(
    "word", ["each=cameras", "cameras=cameras", "in.frames=eyes", "optional=true", "graph=x.yaml"]
)
def test_what_would_change_stages_or_edges_is_refused(tmp_path: Path, word: str) -> None:
    plan = planned(tmp_path, EACH, room=ZONED)
    with pytest.raises(InputError) as caught:
        change_of(plan, [f"tracker.{word}"])
    (mistake,) = caught.value.mistakes
    assert (
        mistake.text
        == f'"{word.partition("=")[0].partition(".")[0]}" of sub-graph "tracker" cannot be changed'
    )
    assert "tracker.PARAMETER=VALUE" in mistake.remedy


def test_the_file_of_a_sub_graph_may_be_edited_while_it_runs(tmp_path: Path) -> None:
    plan = planned(tmp_path, SHARED)
    write(tmp_path, main=SHARED, tracker=TRACKER + "  more: {uses: toy.pair, in: {blobs: detect}}\n")
    assert set(levels(after(plan, "hall.level=0.25")).values()) == {0.25}
