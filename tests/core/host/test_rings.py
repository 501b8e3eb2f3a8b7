"""Ends of rings: whichever workers restart, in whichever order, every edge gets two matching ends."""

from __future__ import annotations

import random
import socket
from pathlib import Path

import pytest
from tests.core.host.chain import chain_plan

from followspot.host.rings import RingEnd, Rings


class Host:
    """Workers that hold the newest end of each edge that they have got."""

    def __init__(self, folder: Path) -> None:
        plan = chain_plan(folder)
        self.rings = Rings(plan, {"a", "b", "c"})
        self.held: dict[tuple[str, int], socket.socket] = {}
        self.running = {"a", "b", "c"}
        for worker in "abc":
            self.give(self.rings.take(worker))

    def give(self, ends: list[RingEnd]) -> None:
        for end in ends:
            old = self.held.pop((end.worker, end.edge), None)
            if old is not None:
                old.close()
            self.held[end.worker, end.edge] = end.socket

    def die(self, worker: str) -> None:
        self.running.discard(worker)
        for key in [key for key in self.held if key[0] == worker]:
            self.held.pop(key).close()

    def begin(self, worker: str) -> None:
        self.rings.renew(worker)
        self.give(self.rings.take(worker))

    def ready(self, worker: str) -> None:
        self.running.add(worker)
        self.give(self.rings.join(worker, self.running - {worker}))

    def connected(self) -> bool:
        pairs = [(("a", 0), ("b", 0)), (("b", 1), ("c", 1))]
        for start, end in pairs:
            self.held[start].setblocking(False)
            self.held[end].setblocking(False)
            try:
                self.held[start].send(b"x")
                if self.held[end].recv(1) != b"x":
                    return False
            except OSError:
                return False
        return True

    def close(self) -> None:
        for end in self.held.values():
            end.close()
        self.rings.close()


@pytest.mark.parametrize("seed", range(20))
def test_every_edge_gets_two_ends_whatever_the_order_of_restarts(tmp_path: Path, seed: int) -> None:
    order = random.Random(seed)
    host = Host(tmp_path)
    assert host.connected()
    for _ in range(5):
        dying = order.sample("abc", order.randint(1, 3))
        for worker in dying:
            host.die(worker)
        for worker in order.sample(dying, len(dying)):
            host.begin(worker)
        if order.random() < 0.5:  # it dies again before it is ready
            host.die(dying[0])
            host.begin(dying[0])
        for worker in order.sample(dying, len(dying)):
            host.ready(worker)
        assert host.connected(), dying
    host.close()


def test_a_reader_of_a_worker_that_will_not_start_sees_the_end_of_stream(tmp_path: Path) -> None:
    plan = chain_plan(tmp_path)
    rings = Rings(plan, {"a", "b", "c"})
    rings.discard("a")
    ends = {end.side: end.socket for end in rings.take("b")}
    ends["receiving"].setblocking(False)
    assert ends["receiving"].recv(1) == b""
    for end in ends.values():
        end.close()
    rings.close()
