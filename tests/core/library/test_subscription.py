"""Subscriptions from the start of a run, which miss nothing: a loop reads the messages of a port."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest
from tests.core.library.scripts import GRAPH, composed, endless

import followspot as fs
from followspot.tracking import Blobs, Tracks


@pytest.mark.parametrize("placement", [None, "camera"])
def test_a_subscription_misses_nothing_and_the_run_is_changed_on_the_way(
    tmp_path: Path, placement: str | None
) -> None:
    seen = []
    with fs.run(
        GRAPH,
        set={"fuse.uses": "balls.bundle", "color.similarity": 0.8},
        frames=30,
        placement=placement,
        ports=["track.tracks"],
        out=tmp_path,
    ) as run:
        for tracks in run["track.tracks"]:
            seen.append(tracks.header.seq)
            if len(seen) == 1:
                assert run.set("color.similarity", 0.85).stages[0].params == {"similarity": 0.85}
                assert run.swap("fuse", "balls.mean").stages[0].uses == "balls.mean"
    assert seen == list(range(30))
    report = run.report
    assert report.ok
    assert report.frames == 30
    assert {row["target"] for row in report.accuracy} == {"green", "red", "blue"}
    assert all(row["in_flight"] == 0 for row in report.ledger)
    assert (tmp_path / "tracks.csv").exists()
    assert "<table>" in report.ledger._repr_html_()
    assert "accuracy against ground truth" in repr(report)
    assert repr(run) == f"<run glowballs ({run.run[:8]}): ended>"


def test_two_ports_in_one_subscription_come_as_they_are_made(tmp_path: Path) -> None:
    with fs.run(GRAPH, frames=10, ports=["track.tracks,color"], out=tmp_path) as run:
        kinds = [type(message) for message in run["track.tracks,color"]]
    assert (kinds.count(Tracks), kinds.count(Blobs)) == (10, 30)


def test_messages_come_to_an_event_loop_as_well(tmp_path: Path) -> None:
    async def count() -> int:
        with fs.run(GRAPH, frames=20, ports=["track.tracks"], out=tmp_path) as run:
            return len([tracks async for tracks in run["track.tracks"]])

    assert asyncio.run(count()) == 20


def test_leaving_the_loop_ends_the_run_at_the_end_of_the_block(tmp_path: Path) -> None:
    with endless(tmp_path, ports=["b"]) as run:
        for number in run["b"]:
            if number.header.seq > 3:
                break
        assert run.status().fired >= 0
        assert not run.over()
    assert run.over()
    assert run.report.stopped
    assert run.report.ok
    with pytest.raises(fs.FollowspotError, match="the run has ended"):
        run.set("b.term", 2)


def test_a_stage_that_fails_ends_the_loop_with_its_error(tmp_path: Path) -> None:
    class Fails(fs.Stage):
        """Raises at the third message."""

        def process(self, tracks: Tracks) -> Tracks:
            if tracks.header.seq == 3:
                raise ValueError("three is too many")
            return tracks

    graph = composed()
    graph.add("fails", Fails, tracks=graph.port("low"))
    run = fs.run(graph, frames=10, ports=["fails"], out=tmp_path)
    with pytest.raises(fs.RunFailed, match="three is too many"):
        list(run["fails"])
    with pytest.raises(fs.RunFailed, match="three is too many"):
        run.wait()
    assert not run.report.ok


def test_a_port_without_a_reader_is_named_before_it_holds_up_the_run_for_ever(tmp_path: Path) -> None:
    with (
        fs.run(GRAPH, frames=200, ports=["track.tracks", "color"], out=tmp_path) as run,
        pytest.raises(fs.FollowspotError, match="no loop reads color, which holds up the run"),
    ):
        list(run["track.tracks"])


def test_waiting_for_a_run_that_waits_for_its_reader_says_so(tmp_path: Path) -> None:
    with fs.run(GRAPH, frames=200, ports=["track.tracks"], out=tmp_path) as run:
        with pytest.raises(fs.FollowspotError, match=r"no loop reads track.tracks, which holds up the run"):
            run.wait()
        with pytest.raises(fs.InputError, match=r"there is no port \"colour\"\n +did you mean \"color\""):
            run["colour"]
    assert run.report is run.report, "the truth is not read again"


@pytest.mark.parametrize("ports", [(), ("track.tracks",)], ids=["later", "from the start"])
def test_a_subscription_to_messages_of_another_type_is_refused(
    tmp_path: Path, ports: tuple[str, ...]
) -> None:
    unending = {"camera.realtime": True, "camera.frames": 0}
    with fs.run(GRAPH, set=unending, ports=ports, out=tmp_path) as run:
        with pytest.raises(fs.FollowspotError, match=r"track\.tracks gives Tracks, not Blobs"):
            run.subscribe("track.tracks", Blobs)
        for tracks in run.subscribe("track.tracks", Tracks):
            assert tracks.xyz.shape[1] == 3
            break
