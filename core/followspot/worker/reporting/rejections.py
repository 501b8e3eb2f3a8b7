"""Reports of what the edges of a worker refused: malformed, or not from the other end of the edge."""

from __future__ import annotations

from followspot.log.collector import LogCollector
from followspot.worker.reporting.report import Warnings
from followspot.worker.worker_edge_factory import WorkerEdgeFactory

_REFUSED = "what was malformed or not from its sender"
_OPEN = "any program that reaches this run can send that, unless hosts have certificates (docs/security.md)"
_CERTIFIED = "a host with a certificate sent that"


class Rejections:
    """Logs the first refusal of each edge at once, and warns of the number of refusals at the end.

    certified: whether sessions of Zenoh need certificates.
    """

    def __init__(self, edge_factory: WorkerEdgeFactory, log: LogCollector, *, certified: bool) -> None:
        self._edge_factory = edge_factory
        self._log = log
        self._source = _CERTIFIED if certified else _OPEN
        self._told: set[str] = set()

    def tell_new(self) -> None:
        """Log a warning for each edge that has begun to refuse something. Safe from any thread."""
        for edge in self._edge_factory.rejected():
            if edge not in self._told:
                self._told.add(edge)
                self._log.say("warning", edge, f"refuses {_REFUSED}{self._from(edge)}")

    def warn(self, warnings: Warnings) -> None:
        """Warn of each edge that refused messages, with their number."""
        for edge, times in self._edge_factory.rejected().items():
            warnings.add(edge, f"refused {times} times {_REFUSED}{self._from(edge)}")

    def _from(self, edge: str) -> str:
        """Where it can have come from: only the ends of a ring have its memory."""
        kinds = {planned.kind for planned in self._edge_factory.plan.edges if planned.name == edge}
        return f"; {self._source}" if "zenoh" in kinds else ""
