"""A link that is stuck, neither whole nor gone, holds nobody up for ever."""

from __future__ import annotations

import time

import pytest
import zenoh
from tests.integration.hosts import free_port
from tests.promises.cable import Cable, session

from followspot.transport.zenoh.session import close_session


@pytest.mark.thorough
def test_a_session_is_closed_though_what_it_sent_does_not_get_through() -> None:
    """Zenoh gives up after ten seconds and raises: that ended a worker without its report."""
    port = free_port()
    with session(listen=port) as here:
        arrived: list[zenoh.Sample] = []
        here.declare_subscriber("stuck", arrived.append)
        cable = Cable(port)
        there = session(connect=[cable.endpoint])
        publisher = there.declare_publisher("stuck", congestion_control=zenoh.CongestionControl.BLOCK)
        while not publisher.matching_status.matching:  # type: ignore[attr-defined]
            time.sleep(0.01)
        cable.hold()
        for _ in range(20):
            publisher.put(bytes(100_000))
        close_session(there)
        assert there.is_closed()
        cable.close()
