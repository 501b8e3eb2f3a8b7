"""Publish every port of a worker to Zenoh clients (docs/wire.md), at no cost without a subscriber."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress

import zenoh
from zenoh.handlers import Callback

from followspot.graph.plan import Plan
from followspot.messages import InvalidMessage, Message
from followspot.ports.firing import FIRINGS
from followspot.transport.codec import pack
from followspot.transport.keys import port_key
from followspot.transport.zenoh.terms import has_subscriber
from followspot.worker.output_port import OutputPort
from followspot.worker.scheduler import Scheduler
from followspot.worker.worker_edge_factory import WorkerEdgeFactory


class PublishedPort:
    """A tap of one output port that exists while its key has a subscriber. It waits for none."""

    def __init__(self, session: zenoh.Session, key: str, output: OutputPort, scheduler: Scheduler) -> None:
        self.output = output
        self._scheduler = scheduler
        self._publisher = session.declare_publisher(
            key, congestion_control=zenoh.CongestionControl.DROP, priority=zenoh.Priority.DATA_LOW
        )
        self._listener = self._publisher.declare_matching_listener(Callback(self._matched, indirect=False))
        if has_subscriber(self._publisher):
            self._follow()

    def __call__(self, message: Message) -> None:
        """Put the message, or drop it if the network is full or the session closed."""
        with suppress(zenoh.ZError, InvalidMessage):
            self._publisher.put(pack(message))

    def _matched(self, status: zenoh.MatchingStatus) -> None:
        """Follow the first subscriber that comes or the last one that leaves; in a thread of Zenoh."""
        self._scheduler.between_firings(self._follow)

    def _follow(self) -> None:
        self.output.untap(self)
        if has_subscriber(self._publisher):
            self.output.tap(self)


def published(
    edge_factory: WorkerEdgeFactory, scheduler: Scheduler, before: Sequence[PublishedPort] = ()
) -> list[PublishedPort]:
    """Publish those ports of a worker whose messages no edge puts on their key already.

    before: those that are published already. Without a Zenoh session none is published, and all end with it.
    """
    if edge_factory.zenoh.session is None:
        return []
    taken, known = _on_their_keys(edge_factory.plan), {one.output for one in before}
    return [
        PublishedPort(
            edge_factory.zenoh.session,
            port_key(edge_factory.zenoh.run, host, runner.name, port),
            output,
            scheduler,
        )
        for runner, host in (
            (runner, edge_factory.plan.host_of_stage(runner.name)) for runner in scheduler.runners
        )
        for port, output in runner.outputs
        if not (port == FIRINGS or (runner.name, port) in taken or output in known)
    ]


def _on_their_keys(plan: Plan) -> set[tuple[str, str]]:
    """Ports with a Zenoh edge on the port's own key: raw, from the start, and with no policy that drops."""
    return {
        (edge.from_stage, edge.from_port)
        for number, edge in plan.numbered()
        if edge.kind == "zenoh" and edge.codec == "raw" and not (edge.drops or plan.addition(number))
    }
