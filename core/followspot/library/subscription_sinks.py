"""A plan with sinks for the ports that a script subscribes to before the run begins."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from typing import Any
from uuid import uuid4

from followspot.errors import InputError
from followspot.graph.output_ports import chosen_ports, output_ports
from followspot.graph.plan import Plan, PlannedEdge, PlannedStage, PlannedWorker, nearest_kind
from followspot.library.sink import SINK, offer_subscriptions, withdraw_subscriptions
from followspot.library.subscription import Subscription
from followspot.plugins.registry import OFFERED

_WORKER = "python"
"""The worker of the sinks, a thread of this process, if the graph has several workers."""


class SubscriptionSinks:
    """The subscriptions that a script names before the run, and the sinks in the plan that feed them.

    plan: with the sinks; in_process: the workers that are threads of this process.
    """

    def __init__(self, plan: Plan, words: Sequence[str]) -> None:
        """words: names of ports; see `chosen_ports`.

        Raises InputError if there is no such port, or if a class of this process would run elsewhere.
        """
        self.in_process = (plan.workers[0].name,) if len(plan.workers) == 1 else (_WORKER,)
        self.failure: Callable[[], Exception | None] = lambda: None
        """Returns the error of the run; None if it succeeded."""
        self._subscriptions: dict[str, Subscription[Any]] = {}
        self._keys: list[str] = []
        _check_offered(plan)
        self.plan = self._with_sinks(plan, words)

    def found(self, word: str) -> Subscription[Any] | None:
        """The subscription of this name; None if `ports=` did not name it."""
        return self._subscriptions.get(word)

    @contextmanager
    def yielding(self) -> Iterator[None]:
        """Let no subscription hold up the run while the block lasts."""
        with ExitStack() as stack:
            for subscription in self._subscriptions.values():
                stack.enter_context(subscription.yielding())
            yield

    def check_read(self) -> None:
        """Raises FollowspotError if the run waits for a subscription without a reader."""
        for subscription in self._subscriptions.values():
            subscription.check_siblings()

    def close(self) -> None:
        """Close every subscription."""
        for subscription in self._subscriptions.values():
            subscription.close()

    def end(self) -> None:
        """End every subscription: the run is over."""
        for key in self._keys:
            withdraw_subscriptions(key)
        for subscription in self._subscriptions.values():
            subscription.end()

    def _with_sinks(self, plan: Plan, words: Sequence[str]) -> Plan:
        """The plan with a sink for each port that one of the words names."""
        known = output_ports(plan)
        takers: dict[str, list[Subscription[Any]]] = defaultdict(list)
        for word in words:
            chosen = chosen_ports(word, known, "ports", plan.offered)
            subscription = Subscription[Any](
                word,
                [known[port] for port in chosen],
                lossless=not plan.live,
                failure=lambda: self.failure(),
                siblings=self._subscriptions.values(),
            )
            self._subscriptions[word] = subscription
            for port in chosen:
                takers[port].append(subscription)
                subscription.join()
        for port, subscriptions in takers.items():
            plan = self._with_sink(plan, port, subscriptions)
        worker = self.in_process[0]
        if takers and worker not in {found.name for found in plan.workers}:
            plan = replace(plan, workers=(*plan.workers, PlannedWorker(worker)))
        return plan

    def _with_sink(self, plan: Plan, port: str, subscriptions: Sequence[Subscription[Any]]) -> Plan:
        """The plan with a sink that hands the messages of a port to these subscriptions."""
        key = uuid4().hex
        self._keys.append(key)
        offer_subscriptions(key, subscriptions)
        sender, _, output = port.rpartition(".")
        worker = self.in_process[0]
        name = f"subscription-{port.replace('/', '-').replace('.', '-')}"
        sink = PlannedStage(name, name, SINK, {"key": key}, None, worker, live=False)
        kind = nearest_kind(plan.placed(sender), PlannedWorker(worker))
        edge = PlannedEdge(sender, output, name, "message", kind)
        return replace(plan, stages=(*plan.stages, sink), edges=(*plan.edges, edge))


def _check_offered(plan: Plan) -> None:
    """Classes of this process can run in this process only. Raises InputError."""
    offered = [stage.name for stage in plan.stages if stage.uses.startswith(OFFERED)]
    if offered and len(plan.workers) > 1:
        raise InputError.of(
            f"{', '.join(offered)}: a class of this process cannot run beside several workers",
            "put it into a file and name that in plugin_files, or run without a placement",
        )
