"""Ports by the names that sub-graphs give them: `hall.tracks` as well as `hall/track.tracks`."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from tests.core.graph.composed import TRACKER, planned
from tests.core.graph.subgraph_files import MIDDLE, NESTED, SHARED

from followspot.errors import InputError
from followspot.graph.output_ports import chosen_ports, output_ports, port_names
from followspot.graph.plan import Plan
from followspot.graph.plan_data import plan_from_data, plan_to_data
from followspot.library.subscription_sinks import SubscriptionSinks
from followspot_watch.tap_subscriber import tapped_ports

OTHER = TRACKER.replace("outputs: {tracks: track.tracks, forecast: track.forecast, blobs: detect}", "OUTPUTS")


def chosen(plan: Plan, words: str) -> list[str]:
    return [*chosen_ports(words, output_ports(plan), "ports", plan.offered)]


@pytest.mark.parametrize(
    ("outputs", "word", "ports"),
    [
        ("{tracks: track.tracks}", "hall.tracks", ["hall/track.tracks"]),
        ("{positions: track.tracks}", "hall.positions", ["hall/track.tracks"]),
        ("{out: track.forecast}", "hall.out", ["hall/track.forecast"]),
        ("{pairs: pair}", "hall.pairs", ["hall/pair.out"]),
        ("{found: detect}", "hall.found", ["hall/detect/cam0.out", "hall/detect/cam1.out"]),
        ("{all: track}", "hall.all", ["hall/track.tracks", "hall/track.forecast"]),
        ("{pictures: camera}", "hall.pictures", ["eyes/cam0.out", "eyes/cam1.out"]),
    ],
)
def test_an_output_of_a_sub_graph_names_the_ports_behind_it(
    tmp_path: Path, outputs: str, word: str, ports: list[str]
) -> None:
    plan = planned(tmp_path, "graph: g\n" + _main(), tracker=OTHER.replace("OUTPUTS", f"outputs: {outputs}"))
    assert chosen(plan, word) == ports
    again = plan_from_data(plan_to_data(plan))
    assert chosen(again, word) == ports


def test_a_sub_graph_has_the_ports_of_its_interface_and_no_other(tmp_path: Path) -> None:
    tracker = OTHER.replace("OUTPUTS", "outputs: {positions: track.tracks}")
    plan = planned(tmp_path, "graph: g\n" + _main(), tracker=tracker)
    for word in ("hall.out", "hall.tracks"):
        with pytest.raises(InputError, match=f'there is no port "{word}"'):
            chosen(plan, word)
    assert len(chosen(plan, "hall")) > 1, "all that is in it"
    assert chosen(plan, "hall/detect.out") == ["hall/detect/cam0.out", "hall/detect/cam1.out"]
    names = {name for port in output_ports(plan) for name in port_names(port, plan.offered)}
    assert not names & {"hall.out", "hall.tracks"}


def _main() -> str:
    """Without a reader of the outputs."""
    return "".join(line for line in SHARED.splitlines(True)[1:] if "save" not in line)


def test_a_picture_that_passes_through_is_that_of_the_own_cameras_alone(tmp_path: Path) -> None:
    tracker = OTHER.replace("OUTPUTS", "outputs: {pictures: camera}")
    main = _main().replace("{graph: tracker.yaml", "{cameras: 'cameras[name=cam1]', graph: tracker.yaml")
    main = main.replace("each: cameras}", "each: cameras}\n  look: {uses: toy.mosaic, in: {frames: eyes}}")
    tracker = tracker.replace("each: cameras}", "each: 'cameras[kind=infrared]'}")
    plan = planned(tmp_path, main, tracker=tracker)
    assert chosen(plan, "hall.pictures") == ["eyes/cam1.out"]


def test_outputs_of_inner_and_of_fanned_out_sub_graphs_have_names(tmp_path: Path) -> None:
    plan = planned(tmp_path, NESTED, middle=MIDDLE)
    assert plan.offered["hall.tracks"] == plan.offered["hall/inner.tracks"] == ("hall/inner/track.tracks",)
    plan = planned(tmp_path, _main().replace("{graph: tracker", "{each: cameras, graph: tracker"))
    assert plan.offered["hall/cam1.tracks"] == ("hall/cam1/track.tracks",)
    assert plan.offered["hall.tracks"] == ("hall/cam0/track.tracks", "hall/cam1/track.tracks")


def test_the_full_name_of_a_port_stays_and_a_wrong_one_is_answered_with_a_guess(tmp_path: Path) -> None:
    plan = planned(tmp_path, _main(), tracker=OTHER.replace("OUTPUTS", "outputs: {positions: track.tracks}"))
    assert chosen(plan, "hall/track.tracks") == ["hall/track.tracks"]
    with pytest.raises(InputError, match=r'did you mean "hall\.positions"'):
        chosen(plan, "hall.position")


def test_commands_and_scripts_take_the_name_of_an_output(tmp_path: Path) -> None:
    plan = planned(tmp_path, _main(), tracker=OTHER.replace("OUTPUTS", "outputs: {positions: track.tracks}"))
    run: Any = SimpleNamespace(plan=lambda: plan, metadata=lambda: SimpleNamespace(out=tmp_path))
    assert [*tapped_ports("hall.positions", run)] == ["hall/track.tracks"]
    subscribed = SubscriptionSinks(plan, ["hall.positions"])
    assert [e.from_stage for e in subscribed.plan.edges if e.to_stage.startswith("subscription")] == [
        "hall/track"
    ]
    subscribed.end()
