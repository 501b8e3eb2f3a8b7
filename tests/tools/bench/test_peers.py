"""What joins the stages beside followspot gives the graph's own tracks, so that speeds can be compared."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from bench.runtime import peers
from benching.peers import followspot_graph
from benching.peers.contender import Stalled, told
from benching.peers.parts import READY, RESULT, START, Camera, Fusion, Order
from benching.peers.peer_stages import Played
from followspot.context import Context
from followspot.stage import Member

ROOT = Path(__file__).parents[3]
FRAMES = 13
"""The clock starts after ten; targets are confirmed in the third."""


@pytest.fixture(scope="module")
def order(tmp_path_factory: pytest.TempPathFactory) -> Order:
    """Rendered once, played as fast as it goes."""
    folder = tmp_path_factory.mktemp("peers")
    room = str(ROOT / "graphs/rooms/simulated6.yaml")
    made = Order(str(ROOT / "graphs/glowballs.yaml"), room, str(folder), FRAMES, rate=0.0)
    peers.render(made)
    return made


@pytest.fixture(scope="module")
def tracks(order: Order) -> Any:
    """Those of the graph, in one process."""
    order.path(START).write_text("0", encoding="utf-8")
    followspot_graph.run(order, None)
    return result(order)


def result(order: Order) -> Any:
    file = order.path(RESULT)
    found = json.loads(file.read_text(encoding="utf-8"))["tracks"]
    file.unlink()
    return found


def test_the_parts_give_the_tracks_of_the_graph(order: Order, tracks: Any) -> None:
    """Joined by hand: what a camera's process is told is the forecast of the frame set before."""
    fusion = Fusion(order)
    cameras = [Camera(order, camera) for camera in fusion.cameras]
    forecast = None
    for number in range(order.frames):
        forecast = fusion.fuse([camera.blobs(number, forecast) for camera in cameras])
    fusion.report()
    assert result(order) == tracks
    assert len(tracks[-1][0]) >= 3, "targets are tracked"


def test_a_camera_is_ready_once_it_has_its_pictures(order: Order, tmp_path: Path) -> None:
    """Else reading them would be part of what is measured."""
    empty = replace(order, folder=str(tmp_path))
    room = order.plan().room
    member = Member("cameras", next(iter(room.cameras)))
    played = Played(Context("camera", room, member), order=str(empty.written()))
    with pytest.raises(FileNotFoundError):
        played.setup()
    assert not list(tmp_path.glob(f"{READY}*"))


def test_a_contender_that_stalls_is_told_and_ended(order: Order) -> None:
    with pytest.raises(Stalled, match="0 cameras were ready"):
        told(order, peers.CONTENDERS["multiprocessing"], longest=0.0)
    assert not any(order.folder.encode() in command for command in command_lines())


def command_lines() -> Iterator[bytes]:
    """Of all processes that are alive."""
    for file in Path("/proc").glob("[0-9]*/cmdline"):
        with suppress(OSError):
            yield file.read_bytes()


def test_a_stalled_round_is_left_out(order: Order, monkeypatch: pytest.MonkeyPatch) -> None:
    def stalled(*_: object) -> None:
        raise Stalled("the graph did not begin")

    monkeypatch.setattr(peers, "measured", stalled)
    assert peers.one_round(order, "dora") == []
    assert peers.text(peers.parser().parse_args([]), {}) == "no contender came to its end"


@pytest.mark.thorough
@pytest.mark.parametrize("name", list(peers.CONTENDERS))
def test_every_contender_gives_the_tracks_of_the_graph(name: str, order: Order, tracks: Any) -> None:
    if name in peers.NEEDS:
        pytest.importorskip(peers.NEEDS[name], reason=f"{name} is not installed")
    found = told(order, peers.CONTENDERS[name])
    assert found.report["tracks"] == tracks
    assert len(found.report["latencies_ms"]) == FRAMES - 10
    assert found.cpu > 0
    assert found.memory_mb > 0
    assert found.others >= 0
