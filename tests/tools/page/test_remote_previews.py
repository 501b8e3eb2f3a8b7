"""Previews from other hosts: what is sent when, and who may speak for whom."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator

import numpy as np
import pytest
import zenoh

from followspot import Context, Network
from followspot.messages import Header, Message, stamped
from followspot.taps.framing import head_of
from followspot.tracking import Blobs, Frame
from followspot.transport.keys import tap_key
from followspot.transport.zenoh.post import ZenohPost
from followspot.transport.zenoh.session import locators, open_session
from followspot.wire import pack
from followspot_dashboard.tap import Tap
from followspot_page.taps.remote_previews import RemotePreviews
from followspot_page.taps.shown_ports import TAP, ShownPort

FRAMES = ShownPort("camera/cam0.out", Frame, "pc-left", source=True)
BLOBS = ShownPort("color/cam0.out", Blobs, "pc-left", source=False)


@pytest.fixture
def worker() -> Iterator[zenoh.Session]:
    """The session of a worker on another host."""
    session = open_session()
    yield session
    session.close()  # type: ignore[no-untyped-call]


def post(session: zenoh.Session, run: str, port: ShownPort) -> ZenohPost:
    return ZenohPost(session, tap_key(run, port.host, port.name, TAP))


def at(ms: int, message: Message) -> Message:
    return stamped(message, Header("camera/cam0", ms, ms * 1_000_000))


def frame(ms: int) -> Message:
    return at(ms, Frame("cam0", np.zeros((48, 64, 3), "u1")))


def blobs(ms: int) -> Message:
    none = np.zeros(0)
    return at(ms, Blobs("cam0", np.zeros((0, 2)), np.zeros((0, 2)), none, none, np.zeros((0, 2), "?")))


async def until(condition: Callable[[], bool]) -> None:
    async with asyncio.timeout(60):
        while not condition():
            await asyncio.sleep(0.005)


def test_pictures_travel_only_while_a_page_shows_them(worker: zenoh.Session) -> None:
    async def select() -> list[tuple[str, int]]:
        seen: list[tuple[str, bytes]] = []
        network = Network(connect=tuple(locators(worker)))
        far = await RemotePreviews.open(network, "run", lambda port, data: seen.append((port, data)))
        posts = {port: post(worker, "run", port) for port in (FRAMES, BLOBS)}
        taps = {p: Tap(Context(post=way), port=p.name, picture_rate=10.0) for p, way in posts.items()}
        for tap in taps.values():
            tap.setup()
        far.select([FRAMES, BLOBS, ShownPort("camera/cam9.out", Frame, "", source=True)])
        await until(lambda: posts[BLOBS].wanted)
        assert not posts[FRAMES].wanted
        taps[FRAMES].process(frame(0))
        far.watch(watched=True)
        await until(lambda: posts[FRAMES].wanted)
        for ms in range(100, 300, 10):  # two periods
            taps[FRAMES].process(frame(ms))
        await until(lambda: len(seen) == 2)
        far.watch(watched=False)
        await until(lambda: not posts[FRAMES].wanted)
        far.close()
        await until(lambda: not posts[BLOBS].wanted)
        return [(port, len(data)) for port, data in seen]

    seen = asyncio.run(select())
    assert [port for port, _ in seen] == [FRAMES.name] * 2
    assert all(size < 2000 for _, size in seen)  # a JPEG, and not the 9216 bytes of the frame


def test_a_host_speaks_for_its_own_ports_only(worker: zenoh.Session) -> None:
    async def select() -> list[str]:
        seen: list[str] = []
        network = Network(connect=tuple(locators(worker)))
        far = await RemotePreviews.open(network, "run", lambda port, data: seen.append(port))
        other = ShownPort("color/cam1.out", Blobs, "pc-left", source=False)
        far.select([BLOBS, other])
        posts = [post(worker, "run", port) for port in (BLOBS, other)]
        await until(lambda: all(way.wanted for way in posts))
        packed = pack(blobs(40))
        data = head_of(BLOBS.name, 0, packed) + packed
        for way, packet in ((posts[1], data), (posts[0], data[:-1]), (posts[0], data[:9]), (posts[0], data)):
            way.send(packet)
        await until(lambda: bool(seen))
        await asyncio.sleep(0.1)
        far.close()
        return seen

    assert asyncio.run(select()) == [BLOBS.name]
